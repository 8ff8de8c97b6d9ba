#pragma once

#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include <highwall/core/abi.h>

namespace ceres {
class Manifold;
}  // namespace ceres

namespace highwall {

// Gaussian knowledge of several blocks together, in square-root form: what marginalization leaves.
//
//   r = A [ x_1 [-] x0_1 ; x_2 [-] x0_2 ; ... ] + b                docs/marginalization.md, Eq. 7
//
// [-] is Minus of each block's manifold (a difference where there is none), x0 the linearization
// point. A: rank x n, of any rank: A^T A is positive semidefinite by construction.
// Domain: that of the manifolds' Minus.
class MarginalPrior final : public ceres::CostFunction {
 public:
  struct Block {
    std::vector<double> linearization_point;    // ambient; its size is that of the block
    const ceres::Manifold* manifold = nullptr;  // null: Euclidean. Must outlive the prior.
  };

  // Throws InvalidArgument if a size does not fit, there is no row, or a value is not finite.
  MarginalPrior(std::vector<Block> blocks, const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

  const std::vector<Block>& blocks() const { return blocks_; }
  const Eigen::MatrixXd& A() const { return A_; }
  const Eigen::VectorXd& b() const { return b_; }
  // First column of block i in A; block i has TangentSize(i) of them.
  Eigen::Index Column(std::size_t i) const { return columns_[i]; }
  Eigen::Index TangentSize(std::size_t i) const { return columns_[i + 1] - columns_[i]; }

 private:
  const std::vector<Block> blocks_;
  const Eigen::MatrixXd A_;
  const Eigen::VectorXd b_;
  std::vector<Eigen::Index> columns_;  // one more than there are blocks
};

}  // namespace highwall
