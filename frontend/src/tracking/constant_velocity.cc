#include "tracking/constant_velocity.h"

#include <algorithm>

namespace highwall {
namespace {

// [s] Shorter than the image interval of any camera of this kind: stamps repeat or jitter.
constexpr double kShortestStep = 0.005;

}  // namespace

void ConstantVelocity::Measure(const Pose& T_AB, double dt) {
  if (!(dt >= kShortestStep)) return;
  twist_ = Twist::Between(T_AB, dt);
  step_ = dt;
}

Twist ConstantVelocity::AtBeginning(const ConstantVelocity& before) const {
  if (!(before.step_ > 0.0)) return twist_;
  const double share = before.step_ / (before.step_ + step_);
  return {share * twist_.v + (1.0 - share) * before.twist_.v,
          share * twist_.omega + (1.0 - share) * before.twist_.omega};
}

Pose ConstantVelocity::Predict(double dt) const {
  return twist_.Over(std::clamp(dt, 0.0, std::max(kLongestPrediction, step_)));
}

}  // namespace highwall
