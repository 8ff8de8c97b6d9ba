#pragma once

#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/option_table.h>

namespace [[gnu::visibility("default")]] highwall {

void ForEachOption(OptionsOf<BundleAdjustmentOptions> auto& options, const auto& visit) {
  visit("point_huber", options.point_huber, Positive().In("sigma"));
  visit("line_huber", options.line_huber, Positive().In("sigma"));
  visit("inliers", options.inliers);
  visit("first_iterations", options.first_iterations, AtLeast(1));
  visit("second_iterations", options.second_iterations, AtLeast(1));
  visit("tolerance", options.tolerance, Finite(AtLeast(0.0)));
  visit("trust_region", options.trust_region, Finite(Positive()));
}

void ForEachOption(OptionsOf<LocalMapperOptions> auto& options, const auto& visit) {
  visit("adjusted_keyframes", options.adjusted_keyframes, AtLeast(2));
  visit("fixed_keyframes", options.fixed_keyframes, AtLeast(1));
  visit("fused_keyframes", options.fused_keyframes, AtLeast(0));
  visit("min_observations", options.min_observations, AtLeast(1));
  visit("refine_corners", options.refine_corners);
  visit("wait", options.wait);
}

}  // namespace highwall
