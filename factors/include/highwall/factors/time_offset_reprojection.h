#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/silent_domain.h>
#include <highwall/core/variable.h>
#include <highwall/factors/point_reprojection.h>

namespace [[gnu::visibility("default")]] highwall {

// Reprojection error of a world point with the time offset t_d between the clocks of the camera and
// the IMU, t_imu = t_cam + t_d, as a variable. The state belongs to the time t_cam + t_d_state of
// the IMU clock; if the image was actually taken at t_cam + t_d, the feature was at z - V (t_d -
// t_d_state) at that time, V being its velocity in the image.
//
//   r = W ( y(p_C) - z + V (t_d - t_d_state) )      docs/factors/time_offset_reprojection.md, Eq. 1
//
// Blocks:  0: T_WB  pose   (7, PoseManifold)
//          1: p_W   point  (3) [m]
//          2: t_d   time offset (1) [s]
// Domain: as PointReprojection; outside of it r = 0, J = 0 and Evaluate returns true.
// Source: Qin, Shen, "Online temporal calibration for monocular visual-inertial systems", 2018.
template <int kRows>
class TimeOffsetReprojection final : public ceres::SizedCostFunction<kRows, 7, 3, 1>,
                                     public SilentOutsideDomain {
  static_assert(kRows == 2 || kRows == 3, "(u, v) or (u, v, disparity)");

 public:
  using Variables = VariableList<Pose, Point, double>;
  using Vector = Eigen::Matrix<double, kRows, 1>;
  using Matrix = Eigen::Matrix<double, kRows, kRows>;
  enum Block { kPose = 0, kPoint = 1, kTimeOffset = 2 };

  // z: (u, v) [px] or (u, v, disparity). velocity: of z [px/s], from the neighbouring image.
  // t_d_state: [s] the offset with which the stamp of the state was computed. Throws
  // InvalidArgument if an argument is not finite.
  TimeOffsetReprojection(const Vector& z, const Vector& velocity, const Matrix& sqrt_information,
                         const RgbdProjection& projection, double t_d_state = 0.0);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const ProjectionRows<kRows> rows_;
  const Vector whitened_velocity_;
  const RgbdProjection projection_;
  const double t_d_state_;
};

// Variants without and with depth.
using PointReprojectionTimeOffset = TimeOffsetReprojection<2>;
using PointReprojectionRgbdTimeOffset = TimeOffsetReprojection<3>;

extern template class TimeOffsetReprojection<2>;
extern template class TimeOffsetReprojection<3>;

}  // namespace highwall
