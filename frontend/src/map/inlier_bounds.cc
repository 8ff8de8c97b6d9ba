#include <highwall/frontend/map/options.h>

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

}  // namespace highwall
