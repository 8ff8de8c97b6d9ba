#include "projected_problem.h"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include <ceres/loss_function.h>
#include <Eigen/Cholesky>

#include "graph_covariance.h"
#include "linearization.h"

namespace highwall::internal {
namespace {

// Adds the information of the residuals to the upper triangle of H, factor by factor: a partial
// evaluation by Ceres and a sparse product of an almost dense matrix would take longer than all
// landmarks together. Returns false if a factor cannot be evaluated.
bool AddInformation(const ceres::Problem& problem,
                    const std::vector<ceres::ResidualBlockId>& residuals,
                    const std::unordered_map<const double*, int>& first_column,
                    Eigen::MatrixXd* H) {
  Linearization linearization(problem, {});
  for (const ceres::ResidualBlockId residual : residuals) {
    const std::optional<Rows> linearized = linearization.Linearize(residual);
    if (!linearized) return false;
    const Rows& rows = *linearized;
    const auto J = rows.matrix.leftCols(rows.matrix.cols() - 1);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(J.cols(), J.cols());
    sum.selfadjointView<Eigen::Upper>().rankUpdate(J.transpose());
    std::vector<Eigen::Index> place;  // of each column
    for (const int index : rows.blocks) {
      const LinearBlock& block = linearization.blocks()[static_cast<std::size_t>(index)];
      const int first = first_column.at(block.values);
      for (int k = 0; k < block.tangent_size; ++k) place.push_back(first + k);
    }
    for (Eigen::Index c = 0; c < sum.cols(); ++c) {
      for (Eigen::Index r = 0; r <= c; ++r) {
        const Eigen::Index at_r = place[static_cast<std::size_t>(r)];
        const Eigen::Index at_c = place[static_cast<std::size_t>(c)];
        (*H)(std::min(at_r, at_c), std::max(at_r, at_c)) += sum(r, c);
      }
    }
  }
  return true;
}

// Returns `unknown` with the unknowns of the projection first, in the order of its columns.
std::vector<double*> InOrder(const VariableProjection& projection,
                             const std::vector<double*>& unknown) {
  std::vector<double*> ordered;
  for (const LandmarkProblem::Block& block : projection.unknowns()) ordered.push_back(block.values);
  const std::unordered_set<const double*> first(ordered.begin(), ordered.end());
  for (double* const block : unknown) {
    if (!first.contains(block)) ordered.push_back(block);
  }
  return ordered;
}

// Returns the first column of each block, and in `count` the number of columns.
std::unordered_map<const double*, int> FirstColumns(const ceres::Problem& problem,
                                                    const std::vector<double*>& blocks,
                                                    int* count) {
  std::unordered_map<const double*, int> first;
  *count = 0;
  for (const double* const block : blocks) {
    first.emplace(block, *count);
    *count += problem.ParameterBlockTangentSize(block);
  }
  return first;
}

}  // namespace

ceres::Problem::Options SharedProblemOptions() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.enable_fast_removal = true;
  return options;
}

ProjectedProblem::ProjectedProblem(ceres::Problem& problem, LandmarkProblem landmarks,
                                   std::vector<ceres::ResidualBlockId> others, double damping,
                                   FactorFaults* faults, VariableProjection::Memory* memory)
    : problem_(problem),
      others_(std::move(others)),
      projection_(std::move(landmarks), damping, faults, memory) {}

void ProjectedProblem::Solve(const ceres::Solver::Options& options,
                             ceres::Solver::Summary* summary) {
  ceres::Problem others(SharedProblemOptions());
  std::vector<double*> blocks;
  const auto add = [&](ceres::CostFunction* cost, ceres::LossFunction* loss) {
    for (double* const block : blocks) {
      if (others.HasParameterBlock(block)) continue;
      others.AddParameterBlock(block, problem_.ParameterBlockSize(block),
                               const_cast<ceres::Manifold*>(problem_.GetManifold(block)));
      if (problem_.IsParameterBlockConstant(block)) others.SetParameterBlockConstant(block);
    }
    others.AddResidualBlock(cost, loss, blocks);
  };
  for (const auto& block : projection_.unknowns()) blocks.push_back(block.values);
  add(&projection_, nullptr);
  for (const ceres::ResidualBlockId residual : others_) {
    problem_.GetParameterBlocksForResidualBlock(residual, &blocks);
    add(const_cast<ceres::CostFunction*>(problem_.GetCostFunctionForResidualBlock(residual)),
        const_cast<ceres::LossFunction*>(problem_.GetLossFunctionForResidualBlock(residual)));
  }
  ceres::Solve(options, &others, summary);
  if (summary->IsSolutionUsable()) projection_.WriteLandmarks();
}

std::optional<Eigen::MatrixXd> ProjectedProblem::Covariance(
    const std::vector<double*>& unknown, const std::vector<const double*>& wanted) const {
  const std::vector<double*> blocks = InOrder(projection_, unknown);
  int n = 0;
  const auto first = FirstColumns(problem_, blocks, &n);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd eliminated = Eigen::VectorXd::Zero(n);
  if (!projection_.AddInformation(&H, &eliminated)) return std::nullopt;
  if (!AddInformation(problem_, others_, first, &H)) return std::nullopt;
  const Eigen::VectorXd scale = H.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  const Eigen::VectorXd left = H.diagonal().cwiseQuotient(H.diagonal() + eliminated);
  H = (scale.asDiagonal() * H.eval() * scale.asDiagonal()).eval();
  const Eigen::LLT<Eigen::MatrixXd> factors(H.transpose());  // its lower triangle
  // The squared diagonal holds the pivots, which may be rounding errors of the elimination.
  if (factors.info() != Eigen::Success ||
      factors.matrixLLT().diagonal().cwiseAbs2().cwiseProduct(left).minCoeff() <= kMinPivot) {
    return std::nullopt;
  }
  const std::vector<int> columns = ColumnsOf(problem_, wanted, first);
  const auto size = static_cast<Eigen::Index>(columns.size());
  // L^-1 of the unit vectors: P = X^T X, scaled back.
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(n, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const int c = columns[static_cast<std::size_t>(j)];
    if (c >= 0) X(c, j) = scale[c];
  }
  factors.matrixL().solveInPlace(X);
  return X.transpose() * X;
}

}  // namespace highwall::internal
