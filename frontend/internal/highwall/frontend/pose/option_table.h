#pragma once

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

void ForEachOption(OptionsOf<DirectAlignmentOptions> auto& options, const auto& visit) {
  visit("enabled", options.enabled);
}

}  // namespace highwall
