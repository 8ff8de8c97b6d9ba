#include <highwall/frontend/map/options.h>

#include <highwall/frontend/map/option_table.h>

namespace highwall {

void MeasurementOptions::Validate() const {
  RequireInRange(*this, "MeasurementOptions");
}

void MatchingOptions::Validate() const {
  RequireInRange(*this, "MatchingOptions");
}

void InlierBounds::Validate() const {
  RequireInRange(*this, "InlierBounds");
}

void KeyFrameIndexOptions::Validate() const {
  RequireInRange(*this, "KeyFrameIndexOptions");
}

}  // namespace highwall
