#pragma once

#include <atomic>

#include <ceres/iteration_callback.h>

#include <highwall/core/solver.h>
#include "guarded_factor.h"
#include "projected_problem.h"

namespace highwall::internal {

// Applies the callbacks and the stop flag of SolveOptions between iterations.
class SolveCallback final : public ceres::IterationCallback {
 public:
  // projected: the problem whose landmarks are eliminated, null: none.
  SolveCallback(const SolveOptions& options, const internal::FactorFaults& faults,
                const ProjectedProblem* projected)
      : options_(options), faults_(faults), projected_(projected) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    if (faults_.must_stop) return ceres::SOLVER_ABORT;
    if (options_.on_iteration) options_.on_iteration(iteration.iteration, iteration.cost);
    const bool stop = options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed);
    converged_ = !stop && projected_ != nullptr && iteration.iteration > 0 &&
                 iteration.step_is_successful && HasConverged(iteration);
    return stop || converged_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }
  bool converged() const { return converged_; }

 private:
  // Tests the predicted decrease of the next step, where it is known, and of the last one: the
  // actual decrease tested by Ceres also contains the decrease by steps of the landmarks alone,
  // mostly new ones, and would require another step.
  bool HasConverged(const ceres::IterationSummary& iteration) const {
    const double tolerance = options_.function_tolerance;
    if (projected_->Rests(tolerance)) return true;
    return projected_->LandmarksRest(tolerance) &&
           iteration.cost_change <= iteration.relative_decrease * tolerance * iteration.cost;
  }

  const SolveOptions& options_;
  const internal::FactorFaults& faults_;
  const ProjectedProblem* const projected_;
  bool converged_ = false;
};

}  // namespace highwall::internal
