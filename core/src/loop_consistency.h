#pragma once

#include <cstddef>
#include <vector>

#include <highwall/core/pose_graph.h>

// Selects loops of a graph by consistency with other measurements, without a solve. Masks are by
// edge, always true for odometry. docs/pose_graph.md, "Which loops may take part".
namespace highwall::internal {

// Returns the loops that another loop confirms: both ends of one lie a few steps of odometry from
// those of the other, and the chi2 of the cycle through both is below max_chi2. estimate: the
// threshold is lowered if most cycles close much better than their covariance predicts.
std::vector<bool> ConfirmedLoops(const PoseGraph& graph, double max_chi2, bool estimate);

// Returns the more certain half of the loops marked in `candidates` that agree with the current
// poses within max_chi2, where the poses have the covariance of the minimum-variance path of
// `trusted` edges between the ends. A loop is the more certain, the smaller the volume of the
// covariance of its error. Empty if none agrees.
std::vector<std::size_t> SurestPlausibleLoops(const PoseGraph& graph, double max_chi2,
                                              const std::vector<bool>& trusted,
                                              const std::vector<bool>& candidates);

}  // namespace highwall::internal
