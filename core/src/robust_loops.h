#pragma once

#include <functional>
#include <vector>

#include <highwall/core/pose_graph.h>
#include "pose_graph_problem.h"

namespace highwall::internal {

// Runs the solver on a stage of the robust solution, for at most `max_iterations`.
using StageSolver = std::function<SolveSummary(PoseGraphProblem& problem, int max_iterations)>;

// Solves the graph with possibly false loops and returns the final weight of each edge in [0, 1];
// the weight of odometry is 1. The poses are improved in place; the better the initial poses, the
// smaller the influence of a false loop.
std::vector<double> WeighLoops(RobustLoops method, double max_loop_chi2, const StageSolver& solve,
                               PoseGraph* graph);

}  // namespace highwall::internal
