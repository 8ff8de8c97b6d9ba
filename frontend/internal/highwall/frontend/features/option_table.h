#pragma once

#include <array>
#include <numbers>

#include <highwall/frontend/features/options.h>
#include <highwall/internal/option_table.h>

namespace [[gnu::visibility("default")]] highwall {

template <>
inline constexpr std::array kChoices<PointDetector> = {PointDetector::kOrb, PointDetector::kSift};
template <>
inline constexpr std::array kChoices<LineDetector> = {LineDetector::kLsd, LineDetector::kEdLines};
template <>
inline constexpr std::array kChoices<MadRule> = {MadRule::kMedian, MadRule::kPaper};

void ForEachOption(OptionsOf<PyramidOptions> auto& options, const auto& visit) {
  visit("levels", options.levels, Within(1, 16));
  visit("scale_factor", options.scale_factor, AboveTo(1.0, 2.0));
}

void ForEachOption(OptionsOf<OrbExtractorOptions> auto& options, const auto& visit) {
  visit("features", options.features, AtLeast(1));
  visit("pyramid", options.pyramid);
  visit("fast_threshold", options.fast_threshold, Within(1, 255).In("grey levels"));
  visit("min_fast_threshold", options.min_fast_threshold,
        Within(1, options.fast_threshold).In("grey levels"));
  visit("subpixel", options.subpixel);
}

void ForEachOption(OptionsOf<SiftExtractorOptions> auto& options, const auto& visit) {
  visit("features", options.features, AtLeast(1));
  visit("contrast_threshold", options.contrast_threshold, Positive());
}

void ForEachOption(OptionsOf<LineExtractorOptions> auto& options, const auto& visit) {
  visit("detector", options.detector);
  visit("min_length", options.min_length, PositiveShare().In("of the longer image side"));
  visit("max_lines", options.max_lines, AtLeast(1));
  visit("merge", options.merge);
  visit("refine", options.refine);
  visit("descriptors", options.descriptors);
}

void ForEachOption(OptionsOf<FrameBuilderOptions> auto& options, const auto& visit) {
  visit("point_detector", options.point_detector);
  visit("orb", options.orb);
  visit("sift", options.sift);
  visit("lines", options.lines);
  visit("use_points", options.use_points);
  visit("use_lines", options.use_lines);
}

void ForEachOption(OptionsOf<LineGates> auto& options, const auto& visit) {
  visit("max_angle", options.max_angle, AboveTo(0.0, std::numbers::pi / 2).In("rad"));
  visit("min_length_ratio", options.min_length_ratio,
        OptionRange{.min = 0, .max = 1, .below = true});
  visit("max_midpoint_distance", options.max_midpoint_distance, Positive().In("px"));
}

void ForEachOption(OptionsOf<LineMatcherOptions> auto& options, const auto& visit) {
  visit("small_motion", options.small_motion);
  visit("large_motion", options.large_motion);
  visit("max_distance", options.max_distance, Within(0, 256).In("bit"));
  visit("ratio", options.ratio, PositiveShare());
  visit("mad_rule", options.mad_rule);
  visit("mad_k", options.mad_k, Positive());
  visit("min_deviation", options.min_deviation, AtLeast(0.0).In("rad"));
}

}  // namespace highwall
