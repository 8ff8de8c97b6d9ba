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

void ForEachOption(OptionsOf<TriangulationOptions> auto& options, const auto& visit) {
  visit("keyframes", options.keyframes, AtLeast(0));
  visit("min_views", options.min_views, AtLeast(2));
  visit("scarce_points", options.scarce_points, AtLeast(0));
  visit("max_depth_sigma", options.max_depth_sigma, Positive().In("of the depth"));
  visit("max_hamming", options.max_hamming, Within(0, 256).In("bit"));
  visit("ratio", options.ratio, PositiveShare());
}

void ForEachOption(OptionsOf<LocalMapperOptions> auto& options, const auto& visit) {
  visit("bundle", options.bundle);
  visit("adjusted_keyframes", options.adjusted_keyframes, AtLeast(2));
  visit("fixed_keyframes", options.fixed_keyframes, AtLeast(1));
  visit("fused_keyframes", options.fused_keyframes, AtLeast(0));
  visit("min_found_ratio", options.min_found_ratio, Share());
  visit("probation_keyframes", options.probation_keyframes, AtLeast(1));
  visit("min_observations", options.min_observations, AtLeast(1));
  visit("redundant_share", options.redundant_share, PositiveShare());
  visit("redundant_observers", options.redundant_observers, AtLeast(1));
  visit("max_motion_gap", options.max_motion_gap, Positive().In("s"));
  visit("motion_span", options.motion_span, AtLeast(0.0).In("s"));
  visit("max_depth_sigma", options.max_depth_sigma, Positive().In("of the depth"));
  visit("min_line_length", options.min_line_length, Positive().In("m"));
  visit("refine_corners", options.refine_corners);
  visit("triangulation", options.triangulation);
  visit("wait", options.wait);
}

}  // namespace highwall
