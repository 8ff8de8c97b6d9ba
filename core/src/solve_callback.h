#pragma once

#include <atomic>

#include <ceres/iteration_callback.h>

#include <highwall/core/solver.h>
#include "guarded_factor.h"
#include "projected_problem.h"

namespace highwall::internal {

// Applies the callbacks and the stop flag of SolveOptions between iterations, and ends a solve
// whose next step would gain less than the tolerance.
class SolveCallback final : public ceres::IterationCallback {
 public:
  // What the convergence is tested by, besides the rules of Ceres.
  struct Convergence {
    const ProjectedProblem* projected = nullptr;  // whose landmarks are eliminated; null: none
    bool by_gradients = false;                    // the entries of a gradient are comparable
  };
  SolveCallback(const SolveOptions& options, const internal::FactorFaults& faults,
                const Convergence& convergence)
      : options_(options), faults_(faults), convergence_(convergence) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    if (faults_.must_stop) return ceres::SOLVER_ABORT;
    if (options_.on_iteration) options_.on_iteration(iteration.iteration, iteration.cost);
    const bool stop = options_.stop != nullptr && options_.stop->load(std::memory_order_relaxed);
    converged_ =
        !stop && iteration.iteration > 0 && iteration.step_is_successful && HasConverged(iteration);
    last_gradient_norm_ = iteration.gradient_norm;
    return stop || converged_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }
  bool converged() const { return converged_; }

 private:
  bool HasConverged(const ceres::IterationSummary& iteration) const {
    if (convergence_.projected != nullptr) return ProjectedHasConverged(iteration);
    return convergence_.by_gradients && GradientsPredictConvergence(iteration);
  }

  // A step of Gauss-Newton gains g^T H^-1 g / 2. From one step to the next H hardly changes, so the
  // next one gains what the model predicted for the last one times the ratio of the squared
  // gradients. On public pose graphs that is within a factor of ten of what it gains. Not where the
  // cost and its model differ, and not with variables of several types and scales, of which one
  // would dominate the gradient.
  bool GradientsPredictConvergence(const ceres::IterationSummary& iteration) const {
    constexpr double kLeastRatio = 0.5, kLargestRatio = 1.5;  // of the actual gain and the model's
    // The gradient is given as the difference of the variables, of quaternions a chord: it would
    // hide what a rotation of more than a radian means.
    constexpr double kLongestChord = 0.5;
    const double ratio = iteration.relative_decrease;
    if (iteration.gradient_max_norm > kLongestChord) return false;
    if (ratio < kLeastRatio || ratio > kLargestRatio) return false;
    const double shrinkage = iteration.gradient_norm / last_gradient_norm_;
    const double next_gain = iteration.cost_change / ratio * shrinkage * shrinkage;
    return next_gain <= options_.function_tolerance * iteration.cost;
  }

  // Tests the predicted decrease of the next step, where it is known, and of the last one: the
  // actual decrease tested by Ceres also contains the decrease by steps of the landmarks alone,
  // mostly new ones, and would require another step.
  bool ProjectedHasConverged(const ceres::IterationSummary& iteration) const {
    const double tolerance = options_.function_tolerance;
    if (convergence_.projected->Rests(tolerance)) return true;
    return convergence_.projected->LandmarksRest(tolerance) &&
           iteration.cost_change <= iteration.relative_decrease * tolerance * iteration.cost;
  }

  const SolveOptions& options_;
  const internal::FactorFaults& faults_;
  const Convergence convergence_;
  double last_gradient_norm_ = 0.0;
  bool converged_ = false;
};

}  // namespace highwall::internal
