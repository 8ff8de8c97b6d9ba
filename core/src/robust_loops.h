#pragma once

#include <functional>
#include <vector>

#include <highwall/core/pose_graph.h>
#include "pose_graph_problem.h"

namespace highwall::internal {

// Runs the solver on a stage of the robust solution, for at most that many iterations.
using StageSolver = std::function<SolveSummary(PoseGraphProblem& problem, int max_iterations)>;

// Solves the graph with loops that may be false and returns what each edge weighs in the end, in
// [0, 1]; odometry weighs 1. The poses are improved in place; the better they are to begin with,
// the less a false loop can pull.
std::vector<double> WeighLoops(RobustLoops method, double max_loop_chi2, const StageSolver& solve,
                               PoseGraph* graph);

}  // namespace highwall::internal
