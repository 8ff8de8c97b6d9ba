#include <highwall/frontend/local/options.h>

#include <highwall/frontend/local/option_table.h>

namespace highwall {

void BundleAdjustmentOptions::Validate() const {
  RequireInRange(*this, "BundleAdjustmentOptions");
}

void LocalMapperOptions::Validate() const {
  RequireInRange(*this, "LocalMapperOptions");
}

}  // namespace highwall
