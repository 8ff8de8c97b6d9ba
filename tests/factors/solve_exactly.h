#pragma once

#include <ceres/problem.h>
#include <ceres/solver.h>

namespace highwall {

// Solves to rounding.
inline ceres::Solver::Summary SolveExactly(ceres::Problem* problem) {
  ceres::Solver::Options options;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-20;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  return summary;
}

}  // namespace highwall
