#pragma once

#include <optional>
#include <vector>

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <Eigen/Core>

#include "landmark_problem.h"
#include "variable_projection.h"

namespace highwall::internal {

// Of a problem that owns nothing of what it is made of.
ceres::Problem::Options SharedProblemOptions();

// A problem whose landmarks follow the other variables (variable_projection.h). What it is made of
// must outlive it, and stay as it is: factors, and which blocks are constant.
class ProjectedProblem {
 public:
  // landmarks: blocks that are not constant, which no factor joins. memory: for one at a time.
  ProjectedProblem(ceres::Problem& problem, const std::vector<double*>& landmarks,
                   FactorFaults* faults, VariableProjection::Memory* memory);

  // Ceres is given the other variables, with the landmarks' factors as one function of them.
  void Solve(const ceres::Solver::Options& options, ceres::Solver::Summary* summary);

  // Joint tangent-space covariance of `wanted` given that the landmarks and the blocks `unknown`
  // are estimated, the former eliminated as the solver eliminates them: by its own equations where
  // Solve() has left some. What is left is dense. Blocks of `wanted` that are not among `unknown`
  // get zeros. Empty where a direction is open.
  std::optional<Eigen::MatrixXd> Covariance(const std::vector<double*>& unknown,
                                            const std::vector<const double*>& wanted) const;

 private:
  ProjectedProblem(ceres::Problem& problem, SplitProblem split, FactorFaults* faults,
                   VariableProjection::Memory* memory);

  ceres::Problem& problem_;
  std::vector<ceres::ResidualBlockId> others_;
  VariableProjection projection_;
};

}  // namespace highwall::internal
