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

}  // namespace highwall
