#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include <highwall/core/abi.h>

namespace [[gnu::visibility("default")]] highwall {

namespace internal {
Eigen::MatrixXd SqrtInformation(const Eigen::MatrixXd& covariance);
// Returns empty, and the reason in `fault`, where that throws.
std::optional<Eigen::MatrixXd> TrySqrtInformation(const Eigen::MatrixXd& covariance,
                                                  std::string* fault);
}  // namespace internal

// Returns W, lower triangular, with W^T W = covariance^-1: |W r|^2 is the squared Mahalanobis norm
// of r. covariance: N x N, fixed or dynamic size, unit (unit of r)^2. Throws InvalidArgument if it
// is not finite, square, symmetric (to 1e-9 of its largest entry) and positive definite.
template <class Derived>
Eigen::Matrix<double, Derived::RowsAtCompileTime, Derived::ColsAtCompileTime> SqrtInformation(
    const Eigen::MatrixBase<Derived>& covariance) {
  return internal::SqrtInformation(covariance);
}

}  // namespace highwall
