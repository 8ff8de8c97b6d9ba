#include "graph_covariance.h"

#include <cmath>
#include <unordered_map>

#include <ceres/crs_matrix.h>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <highwall/core/error.h>

namespace highwall::internal {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

// J^T J with unit diagonal has pivots in [0, 1]: 1 for a variable that is independent of those
// before it, rounding for one that the factors do not determine.
constexpr double kMinPivot = 1e-13;

SparseMatrix Linearize(ceres::Problem& problem, const std::vector<double*>& unknown) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = unknown;
  ceres::CRSMatrix J;
  const bool ok = problem.Evaluate(options, nullptr, nullptr, nullptr, &J);
  HIGHWALL_REQUIRE(ok, "Covariance: a factor cannot be evaluated");
  using RowMajor = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(J.num_rows, J.num_cols,
                                    static_cast<Eigen::Index>(J.values.size()), J.rows.data(),
                                    J.cols.data(), J.values.data());
}

}  // namespace

Eigen::MatrixXd TangentCovariance(ceres::Problem& problem, const std::vector<double*>& unknown,
                                  const std::vector<const double*>& wanted) {
  std::unordered_map<const double*, int> first_column;
  int columns = 0;
  for (const double* block : unknown) {
    first_column.emplace(block, columns);
    columns += problem.ParameterBlockTangentSize(block);
  }
  std::vector<int> wanted_columns;  // -1: known
  for (const double* block : wanted) {
    const auto found = first_column.find(block);
    for (int k = 0; k < problem.ParameterBlockTangentSize(block); ++k) {
      wanted_columns.push_back(found == first_column.end() ? -1 : found->second + k);
    }
  }
  const auto size = static_cast<Eigen::Index>(wanted_columns.size());
  if (columns == 0) return Eigen::MatrixXd::Zero(size, size);

  const SparseMatrix J = Linearize(problem, unknown);
  // Zero where no factor says anything; Eigen refuses the norm of a column without rows.
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(columns);
  for (int c = 0; c < columns && J.rows() > 0; ++c) scale[c] = J.col(c).norm();
  const std::string message =
      "Covariance: the factors do not determine every variable (rank-deficient): fix one, or add a "
      "prior";
  HIGHWALL_REQUIRE(scale.allFinite() && scale.minCoeff() > 0.0, message);
  scale = scale.cwiseInverse();
  const SparseMatrix J_scaled = J * scale.asDiagonal();
  const SparseMatrix H = J_scaled.transpose() * J_scaled;
  const Eigen::SimplicialLDLT<SparseMatrix> ldlt(H);
  HIGHWALL_REQUIRE(ldlt.info() == Eigen::Success && ldlt.vectorD().minCoeff() > kMinPivot, message);

  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const int c = wanted_columns[static_cast<std::size_t>(j)];
    if (c < 0) continue;
    const Eigen::VectorXd x = ldlt.solve(Eigen::VectorXd::Unit(columns, c)) * scale[c];
    for (Eigen::Index i = 0; i < size; ++i) {
      const int r = wanted_columns[static_cast<std::size_t>(i)];
      if (r >= 0) covariance(i, j) = scale[r] * x[r];
    }
  }
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace highwall::internal
