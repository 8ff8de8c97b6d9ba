#pragma once

#include <highwall/frontend/calibration/options.h>
#include <highwall/internal/option_table.h>

namespace [[gnu::visibility("default")]] highwall {

void ForEachOption(OptionsOf<DepthPatternOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
  visit("first", options.first, AtLeast(3));
  visit("most", options.most, AtLeast(3));
}

}  // namespace highwall
