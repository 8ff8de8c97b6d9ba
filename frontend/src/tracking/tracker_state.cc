#include "tracking/tracker_state.h"

#include <algorithm>

#include "map/covisibility.h"

namespace highwall {

bool IsReachable(const Pose& motion, double dt) {
  // Above those of a hand that films, or of a vehicle before the scene of a depth camera.
  constexpr double kMaxSpeed = 3.0, kMaxAngularSpeed = 6.0;  // [m/s], [rad/s]
  constexpr double kLongestPause = 1.0;  // [s] stamps in another unit may be any time apart
  if (!(dt > 0.0)) return false;
  const Twist found = Twist::Between(motion, std::min(dt, kLongestPause));
  return found.v.norm() <= kMaxSpeed && found.omega.norm() <= kMaxAngularSpeed;
}

double TrackerState::SinceLast(const Frame& frame) const {
  return ToSeconds(frame.stamp - last->frame.stamp);
}

Pose TrackerState::Extrapolate(const Frame& frame) const {
  return last->T_WC * velocity.Predict(SinceLast(frame));
}

Twist TrackerState::Motion(const PoseConstraint* predicted) const {
  if (!last) return {};
  if (predicted != nullptr && predicted->motion) return *predicted->motion;
  return is_continuous ? velocity.twist() : Twist();
}

bool TrackerState::IsContinuous(const Twist& expected, const TrackedFrame& tracked) const {
  // Above what a hand or a drone does to its camera, and below a cut in the recording.
  constexpr double kMaxAcceleration = 50.0;          // [m/s^2]
  constexpr double kMaxAngularAcceleration = 100.0;  // [rad/s^2]
  const double dt = SinceLast(tracked.frame);
  if (!(dt > 0.0 && dt <= ConstantVelocity::kLongestPrediction)) return false;
  const Twist found = Twist::Between(last->T_WC.Inverse() * tracked.T_WC, dt);
  return (found.v - expected.v).norm() <= kMaxAcceleration * dt &&
         (found.omega - expected.omega).norm() <= kMaxAngularAcceleration * dt;
}

bool TrackerState::IsReachable(const TrackedFrame& tracked) const {
  return highwall::IsReachable(last->T_WC.Inverse() * tracked.T_WC, SinceLast(tracked.frame));
}

std::vector<KeyFrameId> TrackerState::AroundReference(const Map& map, std::size_t most) const {
  return WithNeighbours(map, last->reference, 1, static_cast<int>(most) - 1);
}

}  // namespace highwall
