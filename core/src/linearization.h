#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <Eigen/Core>

#include <highwall/core/marginalization.h>
#include "row_system.h"

namespace highwall::internal {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// An unknown of the linearized problem.
struct LinearBlock {
  double* values = nullptr;  // the block in the problem
  int size = 0;
  int tangent_size = 0;
  const ceres::Manifold* manifold = nullptr;  // null: Euclidean
  // Where Jacobians are taken: the present value, or the first estimate.
  std::vector<double> point;
  RowMajor plus;           // PlusJacobian there, where there is a manifold
  bool moved = false;      // the present value differs from `point`
  Eigen::VectorXd offset;  // present value [-] point, where moved
};

// Turns residual blocks of a problem into rows of a linear least-squares problem over the blocks
// that are not fixed, which get consecutive indices as they are met.
//
// Evaluates the cost functions themselves instead of Problem::EvaluateResidualBlock: the Jacobians
// of first estimates are taken at another state than the residuals, and the user's blocks stay
// untouched.
class Linearization {
 public:
  Linearization(const ceres::Problem& problem, const MarginalizationOptions& options);

  // Throws InvalidArgument if it cannot be evaluated or is not finite.
  Rows Linearize(ceres::ResidualBlockId residual);

  // The unknown's index; -1 if the block is fixed.
  int IndexOf(double* block);

  const std::vector<LinearBlock>& blocks() const { return blocks_; }
  std::vector<int> TangentSizes() const;

 private:
  // A residual block's values at some state.
  struct Evaluation {
    Eigen::VectorXd r;
    std::vector<RowMajor> J;  // ambient; of fixed blocks: anything
  };
  // A residual block as it is linearized, kept for its memory.
  struct Scratch {
    std::vector<double*> values;
    std::vector<int> indices;  // -1: fixed
    std::vector<const double*> present, points;
    std::vector<double*> jacobians;
    std::vector<std::pair<int, std::size_t>> order;  // ascending index, place in the factor
    Evaluation now, first;
  };

  LinearBlock MakeBlock(double* values) const;
  bool Evaluate(const ceres::CostFunction& cost, const std::vector<const double*>& parameters,
                bool with_jacobians, Evaluation* out);
  bool EvaluateUnguarded(const ceres::CostFunction& cost,
                         const std::vector<const double*>& parameters, bool with_jacobians,
                         Evaluation* out);

  const ceres::Problem& problem_;
  // Linearization points of the blocks under a MarginalPrior, where asked for.
  std::unordered_map<const double*, const std::vector<double>*> first_estimates_;
  std::vector<LinearBlock> blocks_;
  std::unordered_map<const double*, int> index_;
  Scratch scratch_;
};

// Residual blocks that touch any of `blocks`, in the order of the problem.
std::vector<ceres::ResidualBlockId> ResidualsOf(const ceres::Problem& problem,
                                                const std::vector<double*>& blocks);

// Throws InvalidArgument unless every block is in the problem, and there once.
void RequireBlocks(const ceres::Problem& problem, const std::vector<double*>& blocks);

}  // namespace highwall::internal
