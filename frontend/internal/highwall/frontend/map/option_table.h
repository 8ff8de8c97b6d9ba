#pragma once

#include <array>

#include <highwall/frontend/features/option_table.h>
#include <highwall/frontend/map/options.h>

namespace [[gnu::visibility("default")]] highwall {

template <>
inline constexpr std::array kChoices<Weighting> = {Weighting::kCovariance, Weighting::kPaper};

void ForEachOption(OptionsOf<InlierBounds> auto& options, const auto& visit) {
  visit("chi2_1", options.chi2_1, Positive());
  visit("chi2_2", options.chi2_2, Positive());
  visit("chi2_3", options.chi2_3, Positive());
  visit("chi2_4", options.chi2_4, Positive());
}

void ForEachOption(OptionsOf<MaxHammingOptions> auto& options, const auto& visit) {
  visit("projection", options.projection, Within(0, 256).In("bit"));
  visit("relocalization", options.relocalization, Within(0, 256).In("bit"));
  visit("triangulation", options.triangulation, Within(0, 256).In("bit"));
}

void ForEachOption(OptionsOf<MeasurementOptions> auto& options, const auto& visit) {
  visit("weighting", options.weighting);
  visit("baseline", options.baseline, Positive().In("m"));
  visit("point_sigma", options.point_sigma, Positive().In("px"));
  visit("line_sigma", options.line_sigma, Positive().In("px"));
  visit("motion_radius", options.motion_radius, Positive().In("px"));
  visit("max_hamming", options.max_hamming);
  visit("mad_rule", options.mad_rule);
}

void ForEachOption(OptionsOf<MatchingOptions> auto& options, const auto& visit) {
  visit("map_radius", options.map_radius, Positive().In("px"));
  visit("min_view_cosine", options.min_view_cosine, Within(-1.0, 1.0));
  visit("min_line_pixels", options.min_line_pixels, AtLeast(1.0).In("px"));
  visit("motion_ratio", options.motion_ratio, PositiveShare());
  visit("map_ratio", options.map_ratio, PositiveShare());
  visit("max_angle_diff", options.max_angle_diff, Positive().In("deg"));
  visit("lines", options.lines);
}

void ForEachOption(OptionsOf<KeyFrameIndexOptions> auto& options, const auto& visit) {
  visit("tables", options.tables, Within(1, 12));
  visit("max_signature_bits", options.max_signature_bits, Within(0, 32).In("bit"));
  visit("line_weight", options.line_weight, AtLeast(0.0));
}

}  // namespace highwall
