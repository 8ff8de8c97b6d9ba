#include <highwall/core/marginalization.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include <ceres/problem.h>
#include <Eigen/QR>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>
#include "linearization.h"
#include "row_system.h"
#include "try_marginalize.h"

namespace highwall {
namespace {

using internal::Linearization;
using internal::Rows;
using internal::RowSystem;

// log det(I + s^2 A^T A) / 2, from the triangle of [s A; I].
double HalfLogDet(const Eigen::MatrixXd& A_b, double s) {
  const Eigen::Index n = A_b.cols() - 1;
  Eigen::MatrixXd stacked(A_b.rows() + n, n);
  stacked.topRows(A_b.rows()) = s * A_b.leftCols(n);
  stacked.bottomRows(n).setIdentity();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(stacked);
  return qr.matrixQR().diagonal().array().abs().log().sum();
}

// Collects all rows, or all except those connected to a block of [first, last).
RowSystem Collect(const std::vector<Rows>& all, const std::vector<int>& sizes, double tolerance,
                  int first, int last) {
  RowSystem system(sizes, tolerance);
  for (const Rows& rows : all) {
    const auto inside = [&](int block) { return block >= first && block < last; };
    if (std::none_of(rows.blocks.begin(), rows.blocks.end(), inside)) system.Add(rows);
  }
  return system;
}

std::vector<int> Range(int first, int last) {
  std::vector<int> range(static_cast<std::size_t>(std::max(0, last - first)));
  std::iota(range.begin(), range.end(), first);
  return range;
}

}  // namespace

void InformationLossOptions::Validate() const {
  RequirePositiveFinite(reference_sigma, "InformationLossOptions::reference_sigma");
  marginalization.Validate();
}

std::vector<double> InformationLoss(const ceres::Problem& problem,
                                    std::span<const std::vector<double*>> candidates,
                                    const InformationLossOptions& options) {
  std::string fault;
  auto loss = internal::TryInformationLoss(problem, candidates, options, &fault);
  HIGHWALL_REQUIRE(loss, fault);
  return std::move(*loss);
}

std::optional<std::vector<double>> internal::TryInformationLoss(
    const ceres::Problem& problem, std::span<const std::vector<double*>> candidates,
    const InformationLossOptions& options, std::string* fault) {
  options.Validate();
  std::vector<double*> states;
  for (const auto& candidate : candidates) {
    states.insert(states.end(), candidate.begin(), candidate.end());
  }
  internal::RequireBlocks(problem, states);

  // The states come first in the indices, candidate by candidate; fixed blocks have no index.
  Linearization linearization(problem, options.marginalization);
  std::vector<int> bounds = {0};
  for (const auto& candidate : candidates) {
    for (double* block : candidate) linearization.IndexOf(block);
    bounds.push_back(static_cast<int>(linearization.blocks().size()));
  }
  std::vector<ceres::ResidualBlockId> residuals;
  problem.GetResidualBlocks(&residuals);
  std::vector<Rows> all;
  all.reserve(residuals.size());
  for (const ceres::ResidualBlockId residual : residuals) {
    std::optional<Rows> rows = linearization.Linearize(residual);
    if (!rows) break;
    if (!rows->blocks.empty()) all.push_back(std::move(*rows));
  }
  *fault = linearization.fault();
  if (!fault->empty()) return std::nullopt;

  const std::vector<int> sizes = linearization.TangentSizes();
  const double tolerance = options.marginalization.rank_tolerance;
  const std::vector<int> others = Range(bounds.back(), static_cast<int>(sizes.size()));
  RowSystem with_all = Collect(all, sizes, tolerance, 0, 0);
  with_all.Eliminate(others);
  std::vector<double> loss;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    std::vector<int> kept = Range(0, bounds[c]);
    const std::vector<int> after = Range(bounds[c + 1], bounds.back());
    kept.insert(kept.end(), after.begin(), after.end());
    RowSystem with = with_all;
    with.Eliminate(Range(bounds[c], bounds[c + 1]));
    RowSystem without = Collect(all, sizes, tolerance, bounds[c], bounds[c + 1]);
    without.Eliminate(others);
    const double s = options.reference_sigma;
    const double nats =
        HalfLogDet(with.Triangular(kept), s) - HalfLogDet(without.Triangular(kept), s);  // Eq. 12
    loss.push_back(std::max(0.0, nats));                                                 // rounding
  }
  return loss;
}

}  // namespace highwall
