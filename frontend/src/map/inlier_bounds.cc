#include <highwall/frontend/map/options.h>

#include <highwall/internal/require.h>

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
  RequirePositive(chi2_1, "InlierBounds::chi2_1");
  RequirePositive(chi2_2, "InlierBounds::chi2_2");
  RequirePositive(chi2_3, "InlierBounds::chi2_3");
  RequirePositive(chi2_4, "InlierBounds::chi2_4");
}

}  // namespace highwall
