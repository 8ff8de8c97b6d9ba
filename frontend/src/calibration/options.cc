#include <highwall/frontend/calibration/options.h>

#include <highwall/frontend/calibration/option_table.h>

namespace highwall {

void DepthPatternOptions::Validate() const {
  RequireInRange(*this, "DepthPatternOptions");
}

}  // namespace highwall
