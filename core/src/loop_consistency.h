#pragma once

#include <cstddef>
#include <vector>

#include <highwall/core/pose_graph.h>

// Which loops of a graph agree with what else is known, before or beside any solving. Masks are by
// edge, odometry always true. docs/pose_graph.md, "Which loops may take part".
namespace highwall::internal {

// Loops that another loop confirms: both ends of one lie a few steps of odometry from those of the
// other, and the cycle through both closes within max_chi2 of its covariance; estimate: sharpened
// where most cycles close much better than that.
std::vector<bool> ConfirmedLoops(const PoseGraph& graph, double max_chi2, bool estimate);

// Of the loops marked in `candidates`, the surer half of those that agree with the present poses to
// max_chi2, when these are as uncertain as the surest path through `trusted` edges between the
// ends; the surer, the smaller the room in which a loop would agree. Empty if none agrees.
std::vector<std::size_t> SurestPlausibleLoops(const PoseGraph& graph, double max_chi2,
                                              const std::vector<bool>& trusted,
                                              const std::vector<bool>& candidates);

}  // namespace highwall::internal
