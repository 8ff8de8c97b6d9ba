#pragma once

#include <Eigen/Core>

#include <highwall/core/abi.h>

namespace [[gnu::visibility("default")]] highwall {

// How a lens bends rays.
enum class LensModel {
  // Radial and tangential (Brown 1966), with the denominator of OpenCV's rational model.
  kRadialTangential,
  // By the angle from the axis (Kannala and Brandt, PAMI 28(8), 2006; OpenCV's fisheye).
  kEquidistant,
};

// A central camera: a pinhole, and the distortion of its lens.
//   m = (x/z, y/z),  r2 = |m|^2,  (u, v) = (fx m'_x + cx, fy m'_y + cy)
// kRadialTangential, the model of OpenCV with up to eight coefficients:
//   q = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3),
//   m'_x = q m_x + 2 p1 m_x m_y + p2 (r2 + 2 m_x^2),
//   m'_y = q m_y + p1 (r2 + 2 m_y^2) + 2 p2 m_x m_y.
// kEquidistant, with k1 to k4:
//   theta = atan(|m|),  m' = m / |m| theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
// Pixel centres have integer coordinates. Camera axes: x right, y down, z forward.
struct PinholeCamera {
  int width = 640;                // [px] > 0
  int height = 480;               // [px] > 0
  double fx = 525.0, fy = 525.0;  // [px] > 0
  double cx = 319.5, cy = 239.5;  // [px]
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0, k4 = 0.0, k5 = 0.0, k6 = 0.0;
  LensModel lens = LensModel::kRadialTangential;

  // Throws InvalidArgument naming the field.
  void Validate() const;

  bool HasDistortion() const;
  // Returns the same intrinsics without distortion: the camera of undistorted pixel coordinates.
  PinholeCamera WithoutDistortion() const;

  // Maps m to m'. dm: the 2 x 2 Jacobian dm'/dm; may be null.
  Eigen::Vector2d Distort(const Eigen::Vector2d& m, Eigen::Matrix2d* dm = nullptr) const;
  // Maps m' to m by Newton's method, to 1e-12 inside the image of a usable lens; where the model
  // folds over (outside of the image) the result is the best point found. Rays of kEquidistant
  // farther than 80 degrees from the axis are mapped to 80 degrees.
  Eigen::Vector2d Undistort(const Eigen::Vector2d& m_distorted) const;

  // Returns the pixel (u, v) of p_C [m], distortion included; requires p_C.z() > 0 (not checked).
  // duv_dp_C: the 2 x 3 Jacobian; may be null.
  Eigen::Vector2d Project(const Eigen::Vector3d& p_C,
                          Eigen::Matrix<double, 2, 3>* duv_dp_C = nullptr) const;
  // Returns the point at depth z [m] behind pixel uv, distortion removed.
  Eigen::Vector3d Unproject(const Eigen::Vector2d& uv, double z) const;
  // Maps a pixel to the pixel of the camera WithoutDistortion().
  Eigen::Vector2d UndistortPixel(const Eigen::Vector2d& uv) const;

  // Returns true inside [0, width - 1] x [0, height - 1] shrunk by `margin` pixels.
  bool Contains(const Eigen::Vector2d& uv, double margin = 0.0) const;
};

// The virtual right camera V (docs/equations.md, section 3): `baseline` metres to the right of C,
// so that depth z becomes the disparity u - u_R = fx baseline / z.
struct VirtualRightCamera {
  double fx = 525.0;       // [px] > 0
  double baseline = 0.08;  // [m] > 0; scales the disparity and its sigma equally

  double Disparity(double z) const { return fx * baseline / z; }
  double Depth(double disparity) const { return fx * baseline / disparity; }
};

}  // namespace highwall
