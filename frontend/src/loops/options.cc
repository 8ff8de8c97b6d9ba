#include <highwall/frontend/loops/options.h>

#include <highwall/frontend/loops/option_table.h>

namespace highwall {

void KeyFrameGraphOptions::Validate() const {
  RequireInRange(*this, "KeyFrameGraphOptions");
}

void LoopDetectorOptions::Validate() const {
  RequireInRange(*this, "LoopDetectorOptions");
}

void LoopCorrectionOptions::Validate() const {
  RequireInRange(*this, "LoopCorrectionOptions");
}

void LoopCloserOptions::Validate() const {
  RequireInRange(*this, "LoopCloserOptions");
}

void UserFactorOptions::Validate() const {
  RequireInRange(*this, "UserFactorOptions");
}

}  // namespace highwall
