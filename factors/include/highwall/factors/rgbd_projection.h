#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>

namespace [[gnu::visibility("default")]] highwall {

// kRows whitened residual rows of one projected point, affine in y = (u, v, delta): r = A y + b.
// Every reprojection row of a point or of a segment's end has this form.
template <int kRows>
struct ProjectionRows {
  Eigen::Matrix<double, kRows, 3> A;
  Eigen::Matrix<double, kRows, 1> b;
};

// Projection model of the RGB-D camera of a body: projects a world point from a pose to undistorted
// pixels.
//
//   y(p_C) = (u, v, delta) = (fx x/z + cx, fy y/z + cy, fx b/z)     docs/factors/rgbd_projection.md
//   p_C = R_CB p_B + p_CB,   p_B = R_BW (p_W - p_WB)                                      Eq. 1, 2
//
// delta = u - u_R is the disparity to the virtual right camera. Value type of 200 bytes without
// virtual functions: the cost functions hold one, and a tracker calls it in its pose-only problem.
// Source: pinhole model; virtual right camera of Xiao et al. 2025, section 3.3.
class RgbdProjection {
 public:
  // Quantities that depend on the pose alone; computed once per pose for all points observed from
  // it.
  struct View {
    Eigen::Vector3d p_WB;
    Eigen::Matrix3d R_BW;
  };

  // camera: without distortion (PinholeCamera::WithoutDistortion), pixels are undistorted by the
  // caller. T_BC: camera in body. right: its fx equals the camera's; its baseline is not used by
  // rows on (u, v) alone. min_depth [m] > 0: nearer points (z < min_depth) are outside of the
  // domain. Throws InvalidArgument if an argument violates this.
  RgbdProjection(const PinholeCamera& camera, const Pose& T_BC, const VirtualRightCamera& right,
                 double min_depth = kDefaultMinDepth);
  // Uses a virtual baseline of 0.08 m.
  RgbdProjection(const PinholeCamera& camera, const Pose& T_BC)
      : RgbdProjection(camera, T_BC, VirtualRightCamera{.fx = camera.fx}) {}

  static constexpr double kDefaultMinDepth = 0.05;  // [m]

  // T_WB: pose block, 7 doubles.
  static View At(const double* T_WB) {
    return {Eigen::Map<const Eigen::Vector3d>(T_WB),
            Eigen::Map<const Eigen::Quaterniond>(T_WB + 3).toRotationMatrix().transpose()};
  }

  // Returns y = (u, v, delta) [px] of p_C [m]; requires p_C.z() > 0 (not checked).
  Eigen::Vector3d Project(const Eigen::Vector3d& p_C) const {
    const double iz = 1.0 / p_C.z();
    return {fx_ * p_C.x() * iz + cx_, fy_ * p_C.y() * iz + cy_, fxb_ * iz};  // Eq. 1
  }

  // Evaluates r = A y(p_C) + b at p_C [m] and, where not null, its Jacobian. Returns false and
  // writes nothing where z < min_depth.
  template <int kRows>
  bool EvaluateInCamera(const Eigen::Vector3d& p_C, const ProjectionRows<kRows>& rows,
                        Eigen::Matrix<double, kRows, 1>* r,
                        Eigen::Matrix<double, kRows, 3>* dr_dp_C) const {
    if (!(p_C.z() >= min_depth_)) return false;
    const Eigen::Vector3d y = Project(p_C);
    *r = rows.A * y + rows.b;
    if (dr_dp_C == nullptr) return true;
    const double iz = 1.0 / p_C.z();
    dr_dp_C->col(0) = rows.A.col(0) * (fx_ * iz);  // Eq. 3
    dr_dp_C->col(1) = rows.A.col(1) * (fy_ * iz);
    dr_dp_C->col(2) = rows.A * (Eigen::Vector3d(cx_, cy_, 0.0) - y) * iz;
    return true;
  }

  // Evaluates the residual at p_W [m] observed from `view`, with the Jacobians in the tangent of
  // PoseManifold and in p_W where not null.
  template <int kRows>
  bool Evaluate(const View& view, const ProjectionRows<kRows>& rows, const Eigen::Vector3d& p_W,
                Eigen::Matrix<double, kRows, 1>* r, Eigen::Matrix<double, kRows, 6>* dr_dpose,
                Eigen::Matrix<double, kRows, 3>* dr_dp_W) const {
    const bool wants_jacobian = dr_dpose != nullptr || dr_dp_W != nullptr;
    const Eigen::Vector3d p_B = view.R_BW * (p_W - view.p_WB);
    const Eigen::Vector3d p_C = R_CB_ * p_B + p_CB_;  // Eq. 2
    Eigen::Matrix<double, kRows, 3> dr_dp_C;
    if (!EvaluateInCamera<kRows>(p_C, rows, r, wants_jacobian ? &dr_dp_C : nullptr)) return false;
    if (!wants_jacobian) return true;
    const Eigen::Matrix<double, kRows, 3> dr_dp_B = dr_dp_C * R_CB_;
    const Eigen::Matrix<double, kRows, 3> J_p_W = dr_dp_B * view.R_BW;  // Eq. 4
    if (dr_dp_W != nullptr) *dr_dp_W = J_p_W;
    if (dr_dpose != nullptr) {
      dr_dpose->template leftCols<3>() = -J_p_W;  // Eq. 5
      for (int i = 0; i < kRows; ++i) {
        dr_dpose->template block<1, 3>(i, 3) = dr_dp_B.row(i).cross(p_B.transpose());
      }
    }
    return true;
  }

  double fx() const { return fx_; }
  double fy() const { return fy_; }
  double cx() const { return cx_; }
  double cy() const { return cy_; }
  double baseline() const { return fxb_ / fx_; }
  double min_depth() const { return min_depth_; }
  // T_CB.
  const Eigen::Matrix3d& R_CB() const { return R_CB_; }
  const Eigen::Vector3d& p_CB() const { return p_CB_; }

 private:
  double fx_, fy_, cx_, cy_;
  double fxb_;  // [px m] focal length times virtual baseline
  double min_depth_;
  Eigen::Matrix3d R_CB_;
  Eigen::Vector3d p_CB_;
};

}  // namespace highwall
