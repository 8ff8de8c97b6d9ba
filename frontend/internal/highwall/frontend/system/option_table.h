#pragma once

#include <highwall/frontend/calibration/option_table.h>
#include <highwall/frontend/inertial/option_table.h>
#include <highwall/frontend/local/option_table.h>
#include <highwall/frontend/loops/option_table.h>
#include <highwall/frontend/system/slam_system.h>
#include <highwall/frontend/tracking/option_table.h>

namespace [[gnu::visibility("default")]] highwall {

void ForEachOption(OptionsOf<SubmapOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
  visit("lost_timeout", options.lost_timeout, AtLeast(0.0).In("s"));
}

void ForEachOption(OptionsOf<SlamOptions> auto& options, const auto& visit) {
  visit("frame", options.frame);
  visit("measurement", options.measurement);
  visit("tracker", options.tracker);
  visit("keyframes", options.keyframes);
  visit("refinement", options.refinement);
  visit("mapper", options.mapper);
  visit("inertial", options.inertial);
  visit("loops", options.loops);
  visit("factors", options.factors);
  visit("depth_pattern", options.depth_pattern);
  visit("submaps", options.submaps);
  visit("localize_only", options.localize_only);
  visit("threads", options.threads, Within(0, 256));
}

}  // namespace highwall
