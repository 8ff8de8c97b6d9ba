#include <highwall/frontend/features/twist.h>

#include <highwall/core/so3.h>

namespace highwall {

Twist Twist::Between(const Pose& T_AB, double dt) {
  // p = Jl(theta) rho, where Jl(theta) = Jr(-theta).
  const Eigen::Vector3d theta = so3::Log(T_AB.q());
  return {so3::RightJacobianInverse(-theta) * T_AB.p() / dt, theta / dt};
}

Pose Twist::Over(double dt) const {
  const Eigen::Vector3d theta = dt * omega;
  return Pose(so3::Exp(theta), so3::RightJacobian(-theta) * (dt * v));
}

}  // namespace highwall
