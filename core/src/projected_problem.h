#pragma once

#include <optional>
#include <vector>

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <Eigen/Core>

#include "landmark_problem.h"
#include "variable_projection.h"

namespace highwall::internal {

// Options of a problem that owns none of its objects.
ceres::Problem::Options SharedProblemOptions();

// A problem whose landmarks are eliminated by one cost function (variable_projection.h). Its
// factors and the set of constant blocks must outlive it and stay unchanged.
class ProjectedProblem {
 public:
  // landmarks: with an unknown at least. others: the other residuals, which are in `problem` with
  // all unknowns. damping: of the landmarks, see VariableProjection. memory: for one at a time.
  ProjectedProblem(ceres::Problem& problem, LandmarkProblem landmarks,
                   std::vector<ceres::ResidualBlockId> others, double damping, FactorFaults* faults,
                   VariableProjection::Memory* memory);

  // Ceres solves for the other variables, with the landmark factors as one function of them.
  void Solve(const ceres::Solver::Options& options, ceres::Solver::Summary* summary);

  // Whether the landmarks alone could hardly lower the cost, by at most this fraction of it, which
  // no stopping rule of Ceres sees. Without damping they do rest at each accepted step.
  bool LandmarksRest(double fraction) const { return projection_.LandmarksRest(fraction); }
  // Whether the next steps of the unknowns and of the landmarks are each predicted to decrease the
  // cost by at most this fraction of it. False where factors without landmarks have a part in it.
  bool Rests(double fraction) const {
    return others_.empty() && projection_.UnknownsRest(fraction) && LandmarksRest(fraction);
  }

  // Returns the joint tangent-space covariance of `wanted` if the landmarks and the blocks
  // `unknown` are estimated, the landmarks eliminated as in the solver: from the equations of
  // Solve() if there are any. The reduced system is dense. Blocks of `wanted` that are not among
  // `unknown` get zeros. Empty if a direction is unobservable or a factor cannot be evaluated. For
  // a problem without damping.
  std::optional<Eigen::MatrixXd> Covariance(const std::vector<double*>& unknown,
                                            const std::vector<const double*>& wanted) const;

 private:
  ceres::Problem& problem_;
  std::vector<ceres::ResidualBlockId> others_;
  VariableProjection projection_;
};

}  // namespace highwall::internal
