#include <highwall/frontend/tracking/options.h>

#include <highwall/frontend/tracking/option_table.h>

namespace highwall {

const char* ToString(FrameTimingMode mode) {
  switch (mode) {
    case FrameTimingMode::kIgnored:
      return "ignored";
    case FrameTimingMode::kKnown:
      return "known";
    case FrameTimingMode::kEstimated:
      break;
  }
  return "estimated";
}

void DynamicObjectOptions::Validate() const {
  RequireInRange(*this, "DynamicObjectOptions");
}

void TrackerOptions::Validate() const {
  RequireInRange(*this, "TrackerOptions");
}

void FrameRefinementOptions::Validate() const {
  RequireInRange(*this, "FrameRefinementOptions");
}

void KeyFramePolicyOptions::Validate() const {
  RequireInRange(*this, "KeyFramePolicyOptions");
}

}  // namespace highwall
