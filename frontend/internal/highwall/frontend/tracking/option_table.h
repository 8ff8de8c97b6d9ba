#pragma once

#include <array>

#include <highwall/frontend/pose/option_table.h>
#include <highwall/frontend/tracking/options.h>

namespace [[gnu::visibility("default")]] highwall {

template <>
inline constexpr std::array kChoices<FrameTimingMode> = {
    FrameTimingMode::kIgnored, FrameTimingMode::kKnown, FrameTimingMode::kEstimated};

void ForEachOption(OptionsOf<RelocalizerOptions> auto& options, const auto& visit) {
  visit("candidates", options.candidates, AtLeast(1));
  visit("max_hamming", options.max_hamming, Within(0, 256).In("bit"));
  visit("ratio", options.ratio, PositiveShare());
  visit("min_matches", options.min_matches, AtLeast(3));
  visit("min_inliers", options.min_inliers, AtLeast(6));
  visit("min_line_inliers", options.min_line_inliers, AtLeast(4));
  visit("ransac_iterations", options.ransac_iterations, AtLeast(1));
  visit("seed", options.seed);
}

void ForEachOption(OptionsOf<DynamicObjectOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
  visit("settled", options.settled, Positive().In("s"));
  visit("max_share", options.max_share, PositiveShare());
  visit("interval", options.interval, Positive().In("s"));
  visit("history", options.history, Above(options.interval).In("s"));
  visit("min_surface", options.min_surface, AtLeast(1).In("cells"));
  visit("max_surface", options.max_surface, PositiveShare());
  visit("landmarks", options.landmarks);
}

void ForEachOption(OptionsOf<SurfaceTrackingOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
  visit("matcher", options.matcher);
  visit("min_support", options.min_support, AtLeast(3));
  visit("min_rows", options.min_rows, AtLeast(1));
  visit("max_sigma", options.max_sigma, Positive().In("m"));
}

void ForEachOption(OptionsOf<TrackerOptions> auto& options, const auto& visit) {
  visit("timing", options.timing);
  visit("learn_noise", options.learn_noise);
  visit("pose", options.pose);
  visit("relocalizer", options.relocalizer);
  visit("moving", options.moving);
  visit("degeneracy", options.degeneracy);
  visit("surfaces", options.surfaces);
  visit("direct", options.direct);
  visit("min_motion_support", options.min_motion_support, AtLeast(6));
  visit("min_support", options.min_support, AtLeast(6));
  visit("min_predicted_support", options.min_predicted_support, AtLeast(6));
  visit("doubtful_agreement", options.doubtful_agreement, Share());
  visit("doubtful_share", options.doubtful_share, Share());
  visit("doubtful_drop", options.doubtful_drop, Share());
  visit("local_keyframes", options.local_keyframes, AtLeast(1));
  visit("recognized_found", options.recognized_found, Share());
  visit("recognized_contradiction", options.recognized_contradiction, Share());
}

void ForEachOption(OptionsOf<FrameRefinementOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
  visit("keyframes", options.keyframes, AtLeast(0));
  visit("waiting", options.waiting, AtLeast(1));
  visit("rounds", options.rounds, AtLeast(1));
}

void ForEachOption(OptionsOf<KeyFramePolicyOptions> auto& options, const auto& visit) {
  visit("min_features", options.min_features, AtLeast(6));
  visit("min_share", options.min_share, PositiveShare());
  visit("max_gap", options.max_gap, Positive().In("s"));
  visit("wanted_tracked", options.wanted_tracked, AtLeast(0));
  visit("wanted_new", options.wanted_new, AtLeast(0));
}

}  // namespace highwall
