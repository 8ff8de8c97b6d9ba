#pragma once

#include <vector>

#include <ceres/problem.h>
#include <Eigen/Core>

namespace highwall::internal {

// Joint tangent-space covariance of `wanted` given that just the blocks `unknown` are estimated;
// blocks of `wanted` that are not among `unknown` get zeros. Throws InvalidArgument if the Jacobian
// with respect to `unknown` has not full column rank or cannot be evaluated.
Eigen::MatrixXd TangentCovariance(ceres::Problem& problem, const std::vector<double*>& unknown,
                                  const std::vector<const double*>& wanted);

// A block of `unknown` with a direction that neither the factors nor the blocks before it hold;
// null where there is none. Throws InvalidArgument if the Jacobian cannot be evaluated.
const double* FindUndetermined(ceres::Problem& problem, const std::vector<double*>& unknown);

}  // namespace highwall::internal
