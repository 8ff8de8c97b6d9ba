#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include <ceres/problem.h>
#include <Eigen/Core>

#include <highwall/core/marginalization.h>

namespace highwall::internal {

// J^T J with unit diagonal has pivots in [0, 1]: 1 for a variable that is independent of those
// before it, rounding error for an unobservable one.
inline constexpr double kMinPivot = 1e-13;

// Returns the joint tangent-space covariance of `wanted` if only the blocks `unknown` are
// estimated; blocks of `wanted` that are not among `unknown` get zeros. Empty if the Jacobian with
// respect to `unknown` does not have full column rank. Throws InvalidArgument if it cannot be
// evaluated.
std::optional<Eigen::MatrixXd> TangentCovariance(ceres::Problem& problem,
                                                 const std::vector<double*>& unknown,
                                                 const std::vector<const double*>& wanted);

// The same with all other blocks marginalized, whether they are observable or not. Empty if a
// direction of `wanted` is unobservable; constant blocks get zeros.
std::optional<Eigen::MatrixXd> MarginalCovariance(ceres::Problem& problem,
                                                  const std::vector<double*>& wanted,
                                                  const MarginalizationOptions& options);

// Returns all columns of the blocks `wanted`, -1 for those of a block without a first column.
std::vector<int> ColumnsOf(const ceres::Problem& problem, const std::vector<const double*>& wanted,
                           const std::unordered_map<const double*, int>& first_column);

// Returns a block of `unknown` with a direction that is not observable from the factors, given the
// blocks before it; null if there is none. Throws InvalidArgument if the Jacobian cannot be
// evaluated.
const double* FindUndetermined(ceres::Problem& problem, const std::vector<double*>& unknown);

}  // namespace highwall::internal
