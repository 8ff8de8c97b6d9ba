#include <highwall/frontend/inertial/inertial_report.h>

namespace highwall {

const char* ToString(InertialStatus status) {
  switch (status) {
    case InertialStatus::kWaiting:
      return "waiting";
    case InertialStatus::kInitializing:
      return "initializing";
    case InertialStatus::kRunning:
      return "running";
    case InertialStatus::kDeadReckoning:
      return "dead reckoning";
    case InertialStatus::kGivenUp:
      return "given up";
  }
  return "unknown";
}

}  // namespace highwall
