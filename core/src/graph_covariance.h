#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include <ceres/problem.h>
#include <Eigen/Core>

#include <highwall/core/marginalization.h>

namespace highwall::internal {

// J^T J with unit diagonal has pivots in [0, 1]: 1 for a variable that is independent of those
// before it, rounding for one that the factors do not determine.
inline constexpr double kMinPivot = 1e-13;

// Joint tangent-space covariance of `wanted` given that just the blocks `unknown` are estimated;
// blocks of `wanted` that are not among `unknown` get zeros. Empty if the Jacobian with respect to
// `unknown` has not full column rank. Throws InvalidArgument if it cannot be evaluated.
std::optional<Eigen::MatrixXd> TangentCovariance(ceres::Problem& problem,
                                                 const std::vector<double*>& unknown,
                                                 const std::vector<const double*>& wanted);

// The same, everything but `wanted` marginalized, whether the factors determine it or not. Empty if
// they leave a direction of `wanted` open; constant blocks get zeros.
std::optional<Eigen::MatrixXd> MarginalCovariance(ceres::Problem& problem,
                                                  const std::vector<double*>& wanted,
                                                  const MarginalizationOptions& options);

// All columns of the blocks that are wanted, -1 for those of one that has no first column.
std::vector<int> ColumnsOf(const ceres::Problem& problem, const std::vector<const double*>& wanted,
                           const std::unordered_map<const double*, int>& first_column);

// A block of `unknown` with a direction that neither the factors nor the blocks before it hold;
// null where there is none. Throws InvalidArgument if the Jacobian cannot be evaluated.
const double* FindUndetermined(ceres::Problem& problem, const std::vector<double*>& unknown);

}  // namespace highwall::internal
