#pragma once

#include <numbers>

#include <highwall/frontend/map/option_table.h>
#include <highwall/frontend/pose/options.h>

namespace [[gnu::visibility("default")]] highwall {

void ForEachOption(OptionsOf<PoseSolverOptions> auto& options, const auto& visit) {
  visit("point_huber", options.point_huber, Positive().In("sigma"));
  visit("line_huber", options.line_huber, Positive().In("sigma"));
  visit("plane_huber", options.plane_huber, Positive().In("sigma"));
  visit("inliers", options.inliers);
  visit("rounds", options.rounds, AtLeast(1));
  visit("max_iterations", options.max_iterations, AtLeast(1));
  visit("min_support", options.min_support, AtLeast(3));
}

void ForEachOption(OptionsOf<DegeneracyOptions> auto& options, const auto& visit) {
  visit("max_sigma", options.max_sigma, Finite(Positive()).In("m"));
}

void ForEachOption(OptionsOf<SurfaceMatcherOptions> auto& options, const auto& visit) {
  visit("stride", options.stride, AtLeast(1).In("cells"));
  visit("radius", options.radius, AtLeast(1).In("cells"));
  visit("min_share", options.min_share, PositiveShare());
  visit("max_incidence", options.max_incidence, Between(0.0, std::numbers::pi / 2).In("rad"));
  visit("max_tilt", options.max_tilt, Positive().In("rad"));
  visit("gate_sigmas", options.gate_sigmas, Positive());
  visit("gate", options.gate, AtLeast(0.0).In("m"));
}

void ForEachOption(OptionsOf<DirectAlignmentOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
  visit("min_rows", options.min_rows, AtLeast(1));
  visit("min_correlation", options.min_correlation, OptionRange{.min = 0, .max = 1, .below = true});
  visit("max_sigma", options.max_sigma, Positive().In("m"));
}

void ForEachOption(OptionsOf<LandmarkMotionOptions> auto& options, const auto& visit) {
  visit("min_points", options.min_points, AtLeast(1));
  visit("min_share", options.min_share, PositiveShare());
  visit("chi2", options.chi2, Positive());
  visit("min_support", options.min_support, AtLeast(6));
  visit("outnumber", options.outnumber, Positive());
}

}  // namespace highwall
