#include "tracking/constant_velocity.h"

#include <algorithm>

#include <highwall/core/so3.h>

namespace highwall {
namespace {

// [s] Faster than any camera of its kind gives images: stamps that repeat or jitter.
constexpr double kShortestStep = 0.005;

}  // namespace

void ConstantVelocity::Measure(const Pose& T_AB, double dt) {
  if (!(dt >= kShortestStep)) return;
  // The screw motion that leads there: p = Jl(theta) rho, where Jl(theta) = Jr(-theta).
  const Eigen::Vector3d theta = so3::Log(T_AB.q());
  v_ = so3::RightJacobianInverse(-theta) * T_AB.p() / dt;
  omega_ = theta / dt;
  step_ = dt;
}

Pose ConstantVelocity::Predict(double dt) const {
  const double t = std::clamp(dt, 0.0, std::max(kLongestPrediction, step_));
  const Eigen::Vector3d theta = t * omega_;
  return Pose(so3::Exp(theta), so3::RightJacobian(-theta) * (t * v_));
}

}  // namespace highwall
