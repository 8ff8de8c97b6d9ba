#include <highwall/factors/white_acceleration.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>
#include <highwall/internal/require.h>

namespace highwall {

void AccelerationNoise::Validate() const {
  RequirePositiveFinite(linear, "AccelerationNoise::linear");
  RequirePositiveFinite(angular, "AccelerationNoise::angular");
}

WhiteAcceleration::WhiteAcceleration(double dt, const AccelerationNoise& noise) : dt_(dt) {
  RequirePositiveFinite(dt, "WhiteAcceleration: dt");
  noise.Validate();
  Vector6 root;  // sqrt(dt q)
  root << Eigen::Vector3d::Constant(std::sqrt(dt * noise.linear)),
      Eigen::Vector3d::Constant(std::sqrt(dt * noise.angular));
  step_ = std::sqrt(12.0) / dt * root.cwiseInverse();
  coupling_ = -std::sqrt(3.0) * root.cwiseInverse();
  rate_ = root.cwiseInverse();
}

bool WhiteAcceleration::Evaluate(double const* const* parameters, double* residuals,
                                 double** jacobians) const {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Matrix12x6 = Eigen::Matrix<double, 12, 6>;
  const Eigen::Map<const Eigen::Vector3d> p_i(parameters[kPoseI]), p_j(parameters[kPoseJ]);
  const Eigen::Map<const Eigen::Quaterniond> q_i(parameters[kPoseI] + 3);
  const Eigen::Map<const Eigen::Quaterniond> q_j(parameters[kPoseJ] + 3);
  const Eigen::Map<const Vector6> u_i(parameters[kVelocitiesI]), u_j(parameters[kVelocitiesJ]);

  const Eigen::Vector3d theta = so3::Log(q_i.conjugate() * q_j);
  Vector6 step;
  step << p_j - p_i, theta;
  const Vector6 e_step = step - dt_ * u_i, e_rate = u_j - u_i;
  if (!e_step.allFinite() || !e_rate.allFinite()) return false;
  Eigen::Map<Eigen::Matrix<double, 12, 1>> r(residuals);
  r << step_.cwiseProduct(e_step) + coupling_.cwiseProduct(e_rate), rate_.cwiseProduct(e_rate);
  if (jacobians == nullptr) return true;

  const auto lift = [&](int block, const Eigen::Matrix3d& dp, const Eigen::Matrix3d& dtheta) {
    if (jacobians[block] == nullptr) return;
    Matrix12x6 J = Matrix12x6::Zero();
    J.block<3, 3>(0, 0) = step_.head<3>().asDiagonal() * dp;
    J.block<3, 3>(3, 3) = step_.tail<3>().asDiagonal() * dtheta;
    PoseManifold::Lift<12>(parameters[block], J, jacobians[block]);
  };
  lift(kPoseI, -Eigen::Matrix3d::Identity(), -so3::RightJacobianInverse(-theta));  // Eq. 4
  lift(kPoseJ, Eigen::Matrix3d::Identity(), so3::RightJacobianInverse(theta));     // Eq. 5
  using RowMajor = Eigen::Matrix<double, 12, 6, Eigen::RowMajor>;
  if (jacobians[kVelocitiesI] != nullptr) {  // Eq. 6
    Eigen::Map<RowMajor> J(jacobians[kVelocitiesI]);
    J.topRows<6>() = Matrix6((-dt_ * step_ - coupling_).asDiagonal());
    J.bottomRows<6>() = Matrix6((-rate_).asDiagonal());
  }
  if (jacobians[kVelocitiesJ] != nullptr) {
    Eigen::Map<RowMajor> J(jacobians[kVelocitiesJ]);
    J.topRows<6>() = Matrix6(coupling_.asDiagonal());
    J.bottomRows<6>() = Matrix6(rate_.asDiagonal());
  }
  return true;
}

}  // namespace highwall
