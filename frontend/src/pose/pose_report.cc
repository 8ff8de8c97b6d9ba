#include <highwall/frontend/pose/pose_report.h>

namespace highwall {

const char* ToString(TrackingState state) {
  switch (state) {
    case TrackingState::kInitializing:
      return "initializing";
    case TrackingState::kTracking:
      return "tracking";
    case TrackingState::kInertial:
      return "inertial";
    case TrackingState::kLost:
      return "lost";
  }
  return "unknown";
}

bool HasPose(TrackingState state) {
  return state == TrackingState::kTracking || state == TrackingState::kInertial;
}

const char* ToString(LossReason reason) {
  switch (reason) {
    case LossReason::kDark:
      return "dark";
    case LossReason::kBlurred:
      return "blurred";
    case LossReason::kPlain:
      return "plain";
    case LossReason::kNoDepth:
      return "no depth";
    case LossReason::kTooFast:
      return "too fast";
    case LossReason::kContradictory:
      return "contradictory";
    case LossReason::kAllMoving:
      return "all moving";
    case LossReason::kUnknownPlace:
      return "unknown place";
    case LossReason::kRepeatedImage:
      return "repeated image";
    case LossReason::kDeadReckoning:
      return "dead reckoning";
  }
  return "unknown";
}

}  // namespace highwall
