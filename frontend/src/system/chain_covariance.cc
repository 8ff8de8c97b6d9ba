#include "system/chain_covariance.h"

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <ceres/crs_matrix.h>
#include <Eigen/Cholesky>
#include <Eigen/SparseCore>

namespace highwall {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

Index TangentSize(const ceres::Problem& problem, std::span<double* const> blocks) {
  Index size = 0;
  for (const double* const block : blocks) size += problem.ParameterBlockTangentSize(block);
  return size;
}

// J^T J of all states and of the common blocks behind them, scaled to a unit diagonal.
struct Information {
  Eigen::SparseMatrix<double> H;
  Eigen::VectorXd scale;     // of the columns of J
  std::vector<Index> first;  // row of each state, then of the common blocks, then the end
};

std::optional<Information> Linearize(ceres::Problem& problem,
                                     std::span<const std::vector<double*>> states,
                                     std::span<double* const> common) {
  Information information;
  information.first = {0};
  ceres::Problem::EvaluateOptions options;
  const auto add = [&](std::span<double* const> blocks) {
    options.parameter_blocks.insert(options.parameter_blocks.end(), blocks.begin(), blocks.end());
    information.first.push_back(information.first.back() + TangentSize(problem, blocks));
  };
  for (const std::vector<double*>& state : states) add(state);
  add(common);
  ceres::CRSMatrix crs;
  if (!problem.Evaluate(options, nullptr, nullptr, nullptr, &crs)) return std::nullopt;
  Eigen::SparseMatrix<double> J = Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>>(
      crs.num_rows, crs.num_cols, static_cast<Index>(crs.values.size()), crs.rows.data(),
      crs.cols.data(), crs.values.data());
  information.scale.resize(J.cols());
  for (Index c = 0; c < J.cols(); ++c) {
    const double norm = J.col(c).norm();
    if (!std::isfinite(norm) || norm == 0.0) return std::nullopt;
    information.scale[c] = 1.0 / norm;
  }
  J = J * information.scale.asDiagonal();
  information.H = J.transpose() * J;
  return information;
}

// A state after the elimination of those before it.
struct Eliminated {
  MatrixXd inverse;  // of its information
  MatrixXd to_next;  // inverse times the information that couples it with the next state
  MatrixXd border;   // information that couples it with the common blocks
};

// Returns the inverse of a positive definite matrix with a diagonal of at most 1.
std::optional<MatrixXd> Inverse(const MatrixXd& A) {
  constexpr double kLeastPivot = 1e-13;  // a smaller one is rounding
  const Eigen::LLT<MatrixXd> llt(A);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd pivots = llt.matrixLLT().diagonal();
  if (pivots.size() > 0 && pivots.cwiseAbs2().minCoeff() < kLeastPivot) return std::nullopt;
  return llt.solve(MatrixXd::Identity(A.rows(), A.cols()));
}

// Eliminates the states one after another. common: information of the common blocks, from which
// that of the states is taken away. Empty if a direction is not observable.
std::vector<Eliminated> Eliminate(const Information& information, std::size_t states,
                                  MatrixXd* common) {
  const auto size_of = [&](std::size_t i) {
    return information.first[i + 1] - information.first[i];
  };
  const auto block = [&](std::size_t i, std::size_t j) -> MatrixXd {
    return information.H.block(information.first[i], information.first[j], size_of(i), size_of(j));
  };
  const Index commons = size_of(states);
  MatrixXd all;  // dense, as its columns are, so that a block is found at once
  if (commons > 0) all = information.H.rightCols(commons);
  const auto border = [&](std::size_t i) -> MatrixXd {
    if (commons == 0) return MatrixXd(size_of(i), 0);
    return all.middleRows(information.first[i], size_of(i));
  };
  *common = border(states);
  std::vector<Eliminated> chain;
  for (std::size_t i = 0; i < states; ++i) {
    MatrixXd own = block(i, i);
    Eliminated state;
    state.border = border(i);
    if (i > 0) {
      const Eliminated& before = chain.back();
      const MatrixXd coupling = block(i, i - 1);
      own -= coupling * before.to_next;
      state.border -= before.to_next.transpose() * before.border;
    }
    std::optional<MatrixXd> inverse = Inverse(own);
    if (!inverse) return {};
    state.inverse = *std::move(inverse);
    if (i + 1 < states) state.to_next = state.inverse * block(i, i + 1);
    *common -= state.border.transpose() * state.inverse * state.border;
    chain.push_back(std::move(state));
  }
  return chain;
}

}  // namespace

std::vector<MatrixXd> ChainCovariance(ceres::Problem& problem,
                                      std::span<const std::vector<double*>> states,
                                      std::span<double* const> common) {
  const std::optional<Information> information = Linearize(problem, states, common);
  if (!information) return {};
  MatrixXd of_common;
  const std::vector<Eliminated> chain = Eliminate(*information, states.size(), &of_common);
  const std::optional<MatrixXd> common_covariance = Inverse(of_common);
  if (chain.size() != states.size() || !common_covariance) return {};
  std::vector<MatrixXd> covariances(states.size());
  MatrixXd given_common;  // covariance of the state after the present one, the common blocks known
  MatrixXd by_common;     // how far that state follows the common blocks
  for (std::size_t i = states.size(); i-- > 0;) {
    const Eliminated& state = chain[i];
    MatrixXd response = state.inverse * state.border, own = state.inverse;
    if (i + 1 < states.size()) {
      own += state.to_next * given_common * state.to_next.transpose();
      response -= state.to_next * by_common;
    }
    given_common = std::move(own);
    by_common = std::move(response);
    const auto scale =
        information->scale.segment(information->first[i], given_common.rows()).asDiagonal();
    covariances[i] =
        scale * (given_common + by_common * *common_covariance * by_common.transpose()) * scale;
  }
  return covariances;
}

}  // namespace highwall
