#pragma once

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <highwall/core/pose_graph.h>

// The information of an edge, which may be zero for components that are not measured.
namespace highwall::internal {

constexpr double kInformationRounding = 1e-9;  // of the largest eigenvalue

// Positive definite, or semidefinite to rounding. information: symmetric, finite.
inline bool IsPositiveSemidefinite(const PoseInformation& information) {
  if (Eigen::LLT<PoseInformation>(information).info() == Eigen::Success) return true;
  // On the heap: g++ takes the members of a bounded matrix for uninitialized.
  const Eigen::MatrixXd dynamic = information;
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dynamic, Eigen::EigenvaluesOnly).eigenvalues();
  return values.minCoeff() >= -kInformationRounding * values.maxCoeff();
}

// W with W^T W = information; upper triangular where that is positive definite.
template <int N>
Eigen::Matrix<double, N, N> SqrtOfInformation(const PoseInformation& information) {
  using Matrix = Eigen::Matrix<double, N, N>;
  const Matrix fixed = information;
  const Eigen::LLT<Matrix> llt(fixed);
  if (llt.info() == Eigen::Success) return llt.matrixU();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(fixed);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

// Returns the inverse; components that are not measured get a very large variance.
template <int N>
Eigen::Matrix<double, N, N> CovarianceOf(const PoseInformation& information) {
  using Matrix = Eigen::Matrix<double, N, N>;
  const Matrix fixed = information;
  if (Eigen::LLT<Matrix>(fixed).info() == Eigen::Success) return fixed.inverse();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(fixed);
  const double least = std::max(kInformationRounding * eigen.eigenvalues().maxCoeff(), 1e-12);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(least).cwiseInverse().asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace highwall::internal
