#include <highwall/frontend/system/slam_system.h>

#include <highwall/frontend/system/option_table.h>

namespace highwall {

void SubmapOptions::Validate() const {
  RequireInRange(*this, "SubmapOptions");
}

void SlamOptions::Validate() const {
  RequireInRange(*this, "SlamOptions");
}

SlamOptions Deterministic(SlamOptions options) {
  options.threads = 0;
  return options;
}

}  // namespace highwall
