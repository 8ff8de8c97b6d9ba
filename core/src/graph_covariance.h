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

// Returns the joint tangent-space covariance of `wanted`, all other blocks estimated as well;
// constant blocks get zeros. Empty if a direction of `wanted` is unobservable, or if a residual
// cannot be evaluated. unknown: all blocks that are not constant.
std::optional<Eigen::MatrixXd> TangentCovariance(ceres::Problem& problem,
                                                 const std::vector<double*>& unknown,
                                                 const std::vector<double*>& wanted);

// The same by marginalization of all other blocks.
std::optional<Eigen::MatrixXd> MarginalCovariance(ceres::Problem& problem,
                                                  const std::vector<double*>& wanted,
                                                  const MarginalizationOptions& options);

// Returns all columns of the blocks `wanted`, -1 for those of a block without a first column.
std::vector<int> ColumnsOf(const ceres::Problem& problem, const std::vector<const double*>& wanted,
                           const std::unordered_map<const double*, int>& first_column);

// Returns a block of `unknown` with a direction that is not observable from the factors, given the
// blocks before it; null if there is none. Empty if a residual cannot be evaluated.
std::optional<const double*> FindUndetermined(ceres::Problem& problem,
                                              const std::vector<double*>& unknown);

}  // namespace highwall::internal
