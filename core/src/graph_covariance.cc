#include "graph_covariance.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <ceres/crs_matrix.h>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "try_marginalize.h"

namespace highwall::internal {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

using RowMajorSparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// Empty if a residual cannot be evaluated.
std::optional<SparseMatrix> Linearize(ceres::Problem& problem,
                                      const std::vector<double*>& unknown) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = unknown;
  ceres::CRSMatrix J;
  if (!problem.Evaluate(options, nullptr, nullptr, nullptr, &J)) return std::nullopt;
  return SparseMatrix(Eigen::Map<const RowMajorSparse>(
      J.num_rows, J.num_cols, static_cast<Eigen::Index>(J.values.size()), J.rows.data(),
      J.cols.data(), J.values.data()));
}

// J^T J of the blocks, scaled to a unit diagonal and factorized.
struct Normal {
  Normal(ceres::Problem& problem, const std::vector<double*>& unknown);

  std::unordered_map<const double*, int> first_column;
  Eigen::VectorXd scale;  // of the columns of J
  Eigen::SimplicialLDLT<SparseMatrix> ldlt;
  bool evaluates = true;                 // false: nothing else is valid
  const double* undetermined = nullptr;  // first block with an unobservable direction
};

Normal::Normal(ceres::Problem& problem, const std::vector<double*>& unknown) {
  std::vector<const double*> block_of;  // each column
  for (const double* block : unknown) {
    first_column.emplace(block, static_cast<int>(block_of.size()));
    block_of.insert(block_of.end(),
                    static_cast<std::size_t>(problem.ParameterBlockTangentSize(block)), block);
  }
  if (block_of.empty()) return;
  const std::optional<SparseMatrix> linearized = Linearize(problem, unknown);
  evaluates = linearized.has_value();
  if (!evaluates) return;
  const SparseMatrix& J = *linearized;
  const auto columns = static_cast<Eigen::Index>(block_of.size());
  // Zero without a factor; Eigen rejects the norm of a column without rows.
  scale = Eigen::VectorXd::Zero(columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    if (J.rows() > 0) scale[c] = J.col(c).norm();
    if (std::isfinite(scale[c]) && scale[c] > 0.0) continue;
    undetermined = block_of[static_cast<std::size_t>(c)];
    return;
  }
  scale = scale.cwiseInverse();
  const SparseMatrix J_scaled = J * scale.asDiagonal();
  const SparseMatrix H = J_scaled.transpose() * J_scaled;
  ldlt.compute(H);
  // The factorization stops at a zero pivot: later columns are not examined.
  const Eigen::VectorXd pivots = ldlt.vectorD();
  for (Eigen::Index k = 0; k < columns; ++k) {
    if (pivots[k] > kMinPivot) continue;
    const Eigen::Index c = ldlt.permutationPinv().indices()[k];
    undetermined = block_of[static_cast<std::size_t>(c)];
    return;
  }
}

}  // namespace

std::vector<int> ColumnsOf(const ceres::Problem& problem, const std::vector<const double*>& wanted,
                           const std::unordered_map<const double*, int>& first_column) {
  std::vector<int> columns;
  for (const double* const block : wanted) {
    const auto found = first_column.find(block);
    for (int k = 0; k < problem.ParameterBlockTangentSize(block); ++k) {
      columns.push_back(found == first_column.end() ? -1 : found->second + k);
    }
  }
  return columns;
}

std::optional<const double*> FindUndetermined(ceres::Problem& problem,
                                              const std::vector<double*>& unknown) {
  const Normal normal(problem, unknown);
  if (!normal.evaluates) return std::nullopt;
  return normal.undetermined;
}

std::optional<Eigen::MatrixXd> TangentCovariance(ceres::Problem& problem,
                                                 const std::vector<double*>& unknown,
                                                 const std::vector<double*>& wanted) {
  const Normal normal(problem, unknown);
  if (!normal.evaluates) return std::nullopt;
  // The unobservable block may be one that is not requested.
  if (normal.undetermined != nullptr) return MarginalCovariance(problem, wanted, {});
  const std::vector<int> wanted_columns =
      ColumnsOf(problem, {wanted.begin(), wanted.end()}, normal.first_column);
  const auto size = static_cast<Eigen::Index>(wanted_columns.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const int c = wanted_columns[static_cast<std::size_t>(j)];
    if (c < 0) continue;
    const Eigen::VectorXd x =
        normal.ldlt.solve(Eigen::VectorXd::Unit(normal.scale.size(), c)) * normal.scale[c];
    for (Eigen::Index i = 0; i < size; ++i) {
      const int r = wanted_columns[static_cast<std::size_t>(i)];
      if (r >= 0) covariance(i, j) = normal.scale[r] * x[r];
    }
  }
  return 0.5 * (covariance + covariance.transpose());
}

std::optional<Eigen::MatrixXd> MarginalCovariance(ceres::Problem& problem,
                                                  const std::vector<double*>& wanted,
                                                  const MarginalizationOptions& options) {
  std::vector<double*> unknown;
  std::vector<Eigen::Index> first_row;  // of each of `wanted` in the result
  Eigen::Index total = 0, unknown_total = 0;
  for (double* const block : wanted) {
    const int size = problem.ParameterBlockTangentSize(block);
    first_row.push_back(total);
    total += size;
    if (problem.IsParameterBlockConstant(block)) continue;
    if (std::find(unknown.begin(), unknown.end(), block) != unknown.end()) continue;
    unknown.push_back(block);
    unknown_total += size;
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(total, total);
  if (unknown.empty()) return covariance;
  std::string fault;
  const std::optional<Marginal> summary = TrySummarize(problem, unknown, options, &fault);
  if (!summary || summary->report.rank < unknown_total) return std::nullopt;
  const Marginal& marginal = *summary;
  const MarginalPrior& prior = *marginal.prior;
  const Eigen::MatrixXd inverse = prior.A().inverse();  // square: full rank
  const auto rows_of = [&](std::size_t i) {
    return inverse.middleRows(prior.Column(i), prior.TangentSize(i));
  };
  std::vector<std::pair<Eigen::Index, std::size_t>> known;  // first row, block of the prior
  for (std::size_t w = 0; w < wanted.size(); ++w) {
    const auto found = std::find(marginal.blocks.begin(), marginal.blocks.end(), wanted[w]);
    if (found == marginal.blocks.end()) continue;
    known.emplace_back(first_row[w], static_cast<std::size_t>(found - marginal.blocks.begin()));
  }
  for (const auto& [row, i] : known) {
    for (const auto& [column, j] : known) {
      covariance.block(row, column, prior.TangentSize(i), prior.TangentSize(j)) =
          rows_of(i) * rows_of(j).transpose();
    }
  }
  return covariance;
}

}  // namespace highwall::internal
