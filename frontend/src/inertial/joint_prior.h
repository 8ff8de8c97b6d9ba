#pragma once

#include <span>

#include <Eigen/Core>

#include <highwall/core/sliding_window_smoother.h>
#include <highwall/core/variable.h>

namespace highwall {

// Adds a prior at the variables' current values with this joint covariance in their tangent spaces,
// in that order: one MarginalPrior. Returns false, and adds nothing, if that is not a covariance.
[[nodiscard]] bool AddJointPrior(const Eigen::MatrixXd& covariance,
                                 std::span<const VariableId> variables,
                                 SlidingWindowSmoother* smoother);

}  // namespace highwall
