#pragma once

#include <array>

#include <highwall/frontend/pose/option_table.h>
#include <highwall/frontend/tracking/options.h>

namespace [[gnu::visibility("default")]] highwall {

template <>
inline constexpr std::array kChoices<FrameTimingMode> = {
    FrameTimingMode::kIgnored, FrameTimingMode::kKnown, FrameTimingMode::kEstimated};

void ForEachOption(OptionsOf<DynamicObjectOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
  visit("max_share", options.max_share, PositiveShare());
}

void ForEachOption(OptionsOf<SurfaceTrackingOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
}

void ForEachOption(OptionsOf<TrackerOptions> auto& options, const auto& visit) {
  visit("timing", options.timing);
  visit("learn_noise", options.learn_noise);
  visit("moving", options.moving);
  visit("degeneracy", options.degeneracy);
  visit("surfaces", options.surfaces);
  visit("direct", options.direct);
  visit("min_support", options.min_support, AtLeast(6));
  visit("doubtful_share", options.doubtful_share, Share());
  visit("local_keyframes", options.local_keyframes, AtLeast(1));
}

void ForEachOption(OptionsOf<FrameRefinementOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
  visit("waiting", options.waiting, AtLeast(1));
  visit("smooth", options.smooth);
}

void ForEachOption(OptionsOf<KeyFramePolicyOptions> auto& options, const auto& visit) {
  visit("min_features", options.min_features, AtLeast(6));
  visit("min_share", options.min_share, PositiveShare());
  visit("max_gap", options.max_gap, Positive().In("s"));
  visit("wanted_tracked", options.wanted_tracked, AtLeast(0));
  visit("wanted_new", options.wanted_new, AtLeast(0));
}

}  // namespace highwall
