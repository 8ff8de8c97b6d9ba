#pragma once

#include <memory>
#include <span>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include <highwall/core/abi.h>

namespace ceres {
class Manifold;
class Problem;
}  // namespace ceres

namespace [[gnu::visibility("default")]] highwall {

// Joint Gaussian prior on several blocks in square-root form: the result of marginalization.
//
//   r = A [ x_1 [-] x0_1 ; x_2 [-] x0_2 ; ... ] + b                docs/marginalization.md, Eq. 7
//
// [-] is Minus of each block's manifold (a difference where there is none), x0 the linearization
// point. A: rank x n, of any rank: A^T A is positive semidefinite by construction.
// Domain: that of the manifolds' Minus.
class MarginalPrior final : public ceres::CostFunction {
 public:
  // A block of the prior.
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

// Options of Marginalize() and Summarize().
struct MarginalizationOptions {
  // A direction is treated as unobservable if its pivot, for Jacobian columns scaled to unit
  // length, is below this value, or below this value times the length that its column had before
  // the elimination: such a pivot is due to rounding. In (0, 1).
  double rank_tolerance = 1e-10;
  // Blocks of a MarginalPrior are linearized at the linearization point of that prior, so that
  // unobservable directions gain no information from one marginalization to the next
  // (docs/marginalization.md, section "First-estimate Jacobians").
  bool first_estimate_jacobians = false;
  // Exceptions to the above, linearized at their current value: calibration.
  std::vector<const double*> relinearized = {};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Statistics of Marginalize().
struct MarginalizationReport {
  int factors = 0;             // linearized residual blocks
  int rows = 0;                // their number of residuals
  int removed_dimensions = 0;  // tangent dimensions of the removed blocks
  int removed_rank = 0;        // of these, the dimensions that the factors observe
  int dimensions = 0;          // tangent dimensions of the blocks of the prior
  int rank = 0;                // of the prior
  int null_space = 0;          // dimensions - rank: directions without information
  // Ratio of largest to smallest singular value of A of the prior, columns scaled to unit length.
  double condition = 1.0;
};

// Result of Marginalize().
struct Marginal {
  std::unique_ptr<MarginalPrior> prior;  // null: no information about the blocks that stay
  std::vector<double*> blocks;           // blocks of the prior, in its order
  MarginalizationReport report;
};

// Returns the prior on the remaining blocks that replaces `removed` and every residual connected to
// them, linearized at the current values with losses applied. Fixed blocks are known: they are in
// no prior. An earlier MarginalPrior is treated as any other residual. The problem is not changed;
// to replace the removed blocks by the prior:
//
//   Marginal marginal = Marginalize(problem, removed);
//   for (double* block : removed) problem.RemoveParameterBlock(block);  // and its residuals
//   if (marginal.prior) {
//     problem.AddResidualBlock(marginal.prior.release(), nullptr, marginal.blocks);
//   }
//
// Works on any ceres::Problem without an EvaluationCallback. The prior refers to the manifolds
// of the problem. Landmarks cost one small QR each: no matrix over all of them is ever formed.
// Throws InvalidArgument if a block is not in the problem or given twice, or if a residual cannot
// be evaluated or is not finite.
Marginal Marginalize(const ceres::Problem& problem, std::span<double* const> removed,
                     const MarginalizationOptions& options = {});

// Returns the prior on `kept` that replaces the whole problem: all other blocks are marginalized.
// Exceptions as above.
Marginal Summarize(const ceres::Problem& problem, std::span<double* const> kept,
                   const MarginalizationOptions& options = {});

// Options of InformationLoss().
struct InformationLossOptions {
  // Standard deviation of the reference prior against which information is measured, in tangent
  // units (m, rad, m/s). > 0. Directions with a larger standard deviation do not contribute, so
  // that the logarithm is finite under gauge freedom.
  double reference_sigma = 10.0;
  MarginalizationOptions marginalization{};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Returns for each candidate for removal the information [nats] about the blocks of the other
// candidates that depends on the residuals connected to it (docs/marginalization.md, Eq. 12),
//
//   I_c = (log det(I + s^2 Lambda) - log det(I + s^2 Lambda_without_c)) / 2  >= 0,
//
// Lambda and Lambda_without_c: information of the blocks of all candidates but c, everything else
// (landmarks, calibration, c) marginalized, with all residuals and without those of c.
// A candidate: the blocks of one instant, such as pose, velocity and bias of a keyframe. The
// candidate with the least loss is the most redundant. Throws InvalidArgument as Marginalize; a
// block may belong to one candidate only.
std::vector<double> InformationLoss(const ceres::Problem& problem,
                                    std::span<const std::vector<double*>> candidates,
                                    const InformationLossOptions& options = {});

}  // namespace highwall
