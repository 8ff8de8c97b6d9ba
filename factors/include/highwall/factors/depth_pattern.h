#pragma once

#include <Eigen/Core>

namespace [[gnu::visibility("default")]] highwall {

// Depth distortion over the image: error of the measured inverse depth (measured minus true), in
// addition to its constant offset. It is given by a coarse grid of nodes, the outer ones on the
// image's outer pixels, with bilinear interpolation between them (docs/factors/depth_pattern.md).
//
//   1/reading = 1/z + o + w(u, v)^T nodes                                                   Eq. 1
//
// Source: Herrera C., Kannala, Heikkila, "Joint depth and color camera calibration with distortion
// correction", PAMI 34(10), 2012, section 2.3, with a distortion pattern of the disparities over
// the image, there one value per pixel.
struct DepthPattern {
  static constexpr int kColumns = 5, kRows = 4, kNodes = kColumns * kRows;
  using Vector = Eigen::Matrix<double, kNodes, 1>;

  Vector nodes = Vector::Zero();  // [1/m] row-major

  // Throws InvalidArgument naming the field unless all nodes are less than 1 in magnitude.
  void Validate() const;

  bool IsZero() const { return nodes.isZero(0.0); }
  // Returns the root mean square of the nodes [1/m].
  double Rms() const;
  // Returns the distortion at a pixel [1/m]; pixels outside of the image are clamped to its edge.
  // width, height: of the image [px], positive.
  double At(double u, double v, int width, int height) const;
  // Returns the bilinear weight w of each node at that pixel; the weights sum to 1.
  static Vector Shares(double u, double v, int width, int height);
};

}  // namespace highwall
