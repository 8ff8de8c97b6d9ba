#pragma once

#include <optional>
#include <string>
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
  // Linearization point: the current value, or the first estimate.
  std::vector<double> point;
  RowMajor plus;           // PlusJacobian at `point`, if there is a manifold
  bool moved = false;      // the current value differs from `point`
  Eigen::VectorXd offset;  // current value [-] point, if moved
};

// Turns residual blocks of a problem into rows of a linear least-squares problem over the blocks
// that are not fixed, which get consecutive indices in the order of their first occurrence.
//
// Evaluates the cost functions itself instead of Problem::EvaluateResidualBlock: the Jacobians at
// first estimates are evaluated at a different state than the residuals, and the user's blocks stay
// unchanged.
class Linearization {
 public:
  Linearization(const ceres::Problem& problem, const MarginalizationOptions& options);

  // Returns empty if it cannot be evaluated or is not finite.
  std::optional<Rows> Linearize(ceres::ResidualBlockId residual);

  // Returns the index of the unknown; -1 if the block is fixed.
  int IndexOf(double* block);

  // Returns the first reason why a residual or a block could not be linearized; empty if all could.
  const std::string& fault() const { return fault_; }

  const std::vector<LinearBlock>& blocks() const { return blocks_; }
  std::vector<int> TangentSizes() const;

 private:
  // Values of a residual block at some state.
  struct Evaluation {
    Eigen::VectorXd r;
    std::vector<RowMajor> J;  // ambient; unspecified for fixed blocks
  };
  // Working memory for the linearization of a residual block.
  struct Scratch {
    std::vector<double*> values;
    std::vector<int> indices;  // -1: fixed
    std::vector<const double*> present, points;
    std::vector<double*> jacobians;
    std::vector<std::pair<int, std::size_t>> order;  // ascending index, place in the factor
    Evaluation now, first;
  };

  LinearBlock MakeBlock(double* values);
  void Fail(const std::string& why);
  bool Evaluate(const ceres::CostFunction& cost, const std::vector<const double*>& parameters,
                bool with_jacobians, Evaluation* out);
  bool EvaluateUnguarded(const ceres::CostFunction& cost,
                         const std::vector<const double*>& parameters, bool with_jacobians,
                         Evaluation* out);

  const ceres::Problem& problem_;
  // Linearization points of the blocks of MarginalPriors, if requested.
  std::unordered_map<const double*, const std::vector<double>*> first_estimates_;
  std::vector<LinearBlock> blocks_;
  std::unordered_map<const double*, int> index_;
  Scratch scratch_;
  std::string fault_;
};

// Returns the residual blocks connected to any of `blocks`, in the order of the problem.
std::vector<ceres::ResidualBlockId> ResidualsOf(const ceres::Problem& problem,
                                                const std::vector<double*>& blocks);

// Throws InvalidArgument unless every block is in the problem and given once.
void RequireBlocks(const ceres::Problem& problem, const std::vector<double*>& blocks);

}  // namespace highwall::internal
