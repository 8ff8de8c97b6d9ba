#include <highwall/frontend/map/options.h>

#include <highwall/core/error.h>

namespace highwall {

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

void InlierBounds::Validate() const {
  HIGHWALL_REQUIRE(chi2_1 > 0.0 && chi2_2 > 0.0 && chi2_3 > 0.0 && chi2_4 > 0.0,
                   "InlierBounds::chi2_1, chi2_2, chi2_3 and chi2_4 must be positive");
}

}  // namespace highwall
