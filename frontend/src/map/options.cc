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

double InlierBounds::Of(int rows) const {
  switch (rows) {
    case 1:
      return chi2_1;
    case 2:
      return chi2_2;
    case 3:
      return chi2_3;
    default:
      return chi2_4;
  }
}

void KeyFrameIndexOptions::Validate() const {
  RequireInRange(*this, "KeyFrameIndexOptions");
}

}  // namespace highwall
