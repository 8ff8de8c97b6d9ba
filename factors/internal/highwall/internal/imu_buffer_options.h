#pragma once

#include <highwall/factors/imu_buffer.h>
#include <highwall/internal/option_table.h>

namespace [[gnu::visibility("default")]] highwall {

void ForEachOption(OptionsOf<ImuBufferOptions> auto& options, const auto& visit) {
  visit("max_step", options.max_step, Finite(Positive()).In("s"));
  visit("horizon", options.horizon, Finite(Above(options.max_step)).In("s"));
}

}  // namespace highwall
