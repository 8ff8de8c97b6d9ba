#include <highwall/frontend/map/options.h>

#include <highwall/frontend/map/option_table.h>

namespace highwall {

void MeasurementOptions::Validate() const {
  RequireInRange(*this, "MeasurementOptions");
}

void ProjectionMatchOptions::Validate() const {
  RequireInRange(*this, "ProjectionMatchOptions");
}

void MapMatcherOptions::Validate() const {
  RequireInRange(*this, "MapMatcherOptions");
}

void InlierBounds::Validate() const {
  RequireInRange(*this, "InlierBounds");
}

void KeyFrameIndexOptions::Validate() const {
  RequireInRange(*this, "KeyFrameIndexOptions");
}

}  // namespace highwall
