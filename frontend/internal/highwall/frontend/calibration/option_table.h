#pragma once

#include <highwall/frontend/calibration/options.h>
#include <highwall/internal/option_table.h>

namespace [[gnu::visibility("default")]] highwall {

void ForEachOption(OptionsOf<DepthPatternOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
}

}  // namespace highwall
