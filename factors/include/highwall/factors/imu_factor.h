#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/core/variable.h>
#include <highwall/factors/imu_preintegration.h>

namespace [[gnu::visibility("default")]] highwall {

constexpr double kStandardGravity = 9.81;  // [m/s^2], docs/conventions.md

// Data of both factors below: the measured motion and its whitening.
struct ImuMeasurement {
  // Arguments and exceptions as ImuFactor.
  ImuMeasurement(const ImuPreintegration& imu, double weight);

  ImuDelta delta;
  Eigen::Matrix<double, 15, 15> W;  // lower triangular, W^T W = weight * covariance^-1
};

// Residual between the motion of two states and a preintegrated IMU measurement, 15 rows.
//
//   r = W [ Log(Delta R(b_g)^T R_i^T R_j)                         docs/factors/imu_factor.md, Eq. 1
//           R_i^T (v_j - v_i - g T) - Delta v(b)
//           R_i^T (p_j - p_i - v_i T - g T^2 / 2) - Delta p(b)
//           b_j - b_i ],   b = b_i
//
// Blocks:  0: T_WB_i  pose      (7, PoseManifold)     3: T_WB_j
//          1: v_WB_i  velocity  (3) [m/s]             4: v_WB_j
//          2: b_i     bias      (6) [b_g b_a]         5: b_j
// Domain:  everywhere; the Jacobian is discontinuous where the rotation error is pi. Evaluate
//          returns false where a value is not finite.
// Source:  Forster, Carlone, Dellaert, Scaramuzza 2017, Eq. 45.
class ImuFactor final : public ceres::SizedCostFunction<15, 7, 3, 6, 7, 3, 6> {
 public:
  using Variables = VariableList<Pose, Eigen::Vector3d, ImuBias, Pose, Eigen::Vector3d, ImuBias>;
  enum Block { kPoseI, kVelocityI, kBiasI, kPoseJ, kVelocityJ, kBiasJ };

  // gravity_W: [m/s^2]. weight: > 0, of |r|^2 (adaptive_imu_weight.h); 1 is the statistically
  // consistent value. Throws InvalidArgument if an argument is not finite or the weight is not
  // positive.
  ImuFactor(const ImuPreintegration& imu, const Eigen::Vector3d& gravity_W, double weight = 1.0);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const ImuMeasurement measurement_;
  const Eigen::Vector3d gravity_W_;
};

// ImuFactor with the direction of gravity as a seventh block: g = gravity * n_W. With this block
// free, the poses keep a reference frame of their own: all rotations of the world leave r
// unchanged.
//
// Blocks:  0 to 5: as ImuFactor;  6: n_W  direction (3, UnitDirectionManifold)
class ImuGravityFactor final : public ceres::SizedCostFunction<15, 7, 3, 6, 7, 3, 6, 3> {
 public:
  using Variables =
      VariableList<Pose, Eigen::Vector3d, ImuBias, Pose, Eigen::Vector3d, ImuBias, UnitDirection>;
  enum Block { kPoseI, kVelocityI, kBiasI, kPoseJ, kVelocityJ, kBiasJ, kGravity };

  // gravity: magnitude [m/s^2] > 0. Other arguments and exceptions as ImuFactor.
  explicit ImuGravityFactor(const ImuPreintegration& imu, double gravity = kStandardGravity,
                            double weight = 1.0);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const ImuMeasurement measurement_;
  const double gravity_;
};

}  // namespace highwall
