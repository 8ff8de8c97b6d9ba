#pragma once

#include <span>

#include <Eigen/Core>

#include <highwall/core/sliding_window_smoother.h>
#include <highwall/core/variable.h>

namespace highwall {

// The variables are known as they are, with this joint covariance in their tangent spaces, in that
// order: one MarginalPrior. Throws InvalidArgument where that is no covariance.
void AddJointPrior(const Eigen::MatrixXd& covariance, std::span<const VariableId> variables,
                   SlidingWindowSmoother* smoother);

}  // namespace highwall
