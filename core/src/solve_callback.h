#pragma once

#include <atomic>

#include <ceres/iteration_callback.h>

#include <highwall/core/solver.h>
#include "guarded_factor.h"

namespace highwall::internal {

// What SolveOptions asks to be told and asked between iterations.
class SolveCallback final : public ceres::IterationCallback {
 public:
  // projected: landmarks follow the other variables.
  SolveCallback(const SolveOptions& options, const internal::FactorFaults& faults, bool projected)
      : options_(options), faults_(faults), projected_(projected) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    if (faults_.must_stop) return ceres::SOLVER_ABORT;
    if (options_.on_iteration) options_.on_iteration(iteration.iteration, iteration.cost);
    const bool stop = options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed);
    converged_ = !stop && projected_ && IsLast(iteration);
    return stop || converged_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }
  bool converged() const { return converged_; }

 private:
  // By what the step was foretold to gain: what Ceres looks at, the cost, also holds what landmarks
  // gain by themselves, most of it new ones, and would ask for a step more.
  bool IsLast(const ceres::IterationSummary& iteration) const {
    return iteration.iteration > 0 && iteration.step_is_successful &&
           iteration.cost_change <=
               iteration.relative_decrease * options_.function_tolerance * iteration.cost;
  }

  const SolveOptions& options_;
  const internal::FactorFaults& faults_;
  const bool projected_;
  bool converged_ = false;
};

}  // namespace highwall::internal
