#include <highwall/core/marginalization.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>

#include <ceres/problem.h>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include "linearization.h"
#include "row_system.h"
#include "try_marginalize.h"

namespace highwall {
namespace {

using internal::LinearBlock;
using internal::Linearization;
using internal::RankRevealed;
using internal::Rows;
using internal::RowSystem;

// Makes the prior [A | b] over the blocks `kept` of the linearization; blocks with zero columns are
// left out. Empty if the prior is not finite.
std::optional<Marginal> MakePrior(const std::vector<LinearBlock>& blocks,
                                  const std::vector<int>& kept, const RankRevealed& revealed,
                                  MarginalizationReport report) {
  Marginal marginal;
  std::vector<MarginalPrior::Block> prior_blocks;
  Eigen::MatrixXd A(revealed.A.rows(), revealed.A.cols());
  Eigen::Index from = 0, to = 0;
  for (const int index : kept) {
    const LinearBlock& block = blocks[static_cast<std::size_t>(index)];
    const auto columns = revealed.A.middleCols(from, block.tangent_size);
    from += block.tangent_size;
    if (columns.isZero(0.0)) continue;
    A.middleCols(to, block.tangent_size) = columns;
    to += block.tangent_size;
    marginal.blocks.push_back(block.values);
    prior_blocks.push_back({block.point, block.manifold});
  }
  report.dimensions = static_cast<int>(to);
  report.rank = static_cast<int>(revealed.A.rows());
  report.null_space = report.dimensions - report.rank;
  report.condition = revealed.condition;
  marginal.report = report;
  if (report.rank > 0) {
    if (!A.leftCols(to).allFinite() || !revealed.b.allFinite()) return std::nullopt;
    marginal.prior =
        std::make_unique<MarginalPrior>(std::move(prior_blocks), A.leftCols(to), revealed.b);
  }
  return marginal;
}

// Linearizes `residuals` and eliminates `removed`.
std::optional<Marginal> Reduce(const ceres::Problem& problem,
                               const std::vector<ceres::ResidualBlockId>& residuals,
                               const std::vector<double*>& removed,
                               const MarginalizationOptions& options, std::string* fault) {
  Linearization linearization(problem, options);
  std::vector<int> eliminated;
  for (double* block : removed) {
    const int index = linearization.IndexOf(block);
    if (index >= 0) eliminated.push_back(index);
  }
  std::vector<Rows> all;
  all.reserve(residuals.size());
  for (const ceres::ResidualBlockId residual : residuals) {
    std::optional<Rows> rows = linearization.Linearize(residual);
    if (!rows) break;
    all.push_back(std::move(*rows));
  }
  *fault = linearization.fault();
  if (!fault->empty()) return std::nullopt;

  MarginalizationReport report;
  report.factors = static_cast<int>(residuals.size());
  RowSystem system(linearization.TangentSizes(), options.rank_tolerance);
  for (Rows& rows : all) {
    report.rows += static_cast<int>(rows.matrix.rows());
    if (!rows.blocks.empty()) system.Add(std::move(rows));
  }
  for (const int index : eliminated) {
    report.removed_dimensions +=
        linearization.blocks()[static_cast<std::size_t>(index)].tangent_size;
  }
  report.removed_rank = system.Eliminate(eliminated);

  // Eliminated blocks have the first indices.
  std::vector<int> kept(linearization.blocks().size() - eliminated.size());
  std::iota(kept.begin(), kept.end(), static_cast<int>(eliminated.size()));
  const RankRevealed revealed =
      internal::RevealRank(system.Triangular(kept), system.Lengths(kept), options.rank_tolerance);
  std::optional<Marginal> marginal = MakePrior(linearization.blocks(), kept, revealed, report);
  if (!marginal) *fault = "Marginalize: the prior is not finite";
  return marginal;
}

// Returns the marginal of the public functions, whose callers vouch for the values.
Marginal Required(std::optional<Marginal> marginal, const std::string& fault) {
  HIGHWALL_REQUIRE(marginal, fault);
  return std::move(*marginal);
}

}  // namespace

void MarginalizationOptions::Validate() const {
  HIGHWALL_REQUIRE(
      rank_tolerance > 0.0 && rank_tolerance < 1.0,
      "MarginalizationOptions::rank_tolerance must be in (0, 1), is " + FixedText(rank_tolerance));
}

Marginal Marginalize(const ceres::Problem& problem, std::span<double* const> removed,
                     const MarginalizationOptions& options) {
  std::string fault;
  return Required(internal::TryMarginalize(problem, removed, options, &fault), fault);
}

Marginal Summarize(const ceres::Problem& problem, std::span<double* const> kept,
                   const MarginalizationOptions& options) {
  std::string fault;
  return Required(internal::TrySummarize(problem, kept, options, &fault), fault);
}

namespace internal {

std::optional<Marginal> TryMarginalize(const ceres::Problem& problem,
                                       std::span<double* const> removed,
                                       const MarginalizationOptions& options, std::string* fault) {
  options.Validate();
  const std::vector<double*> blocks(removed.begin(), removed.end());
  RequireBlocks(problem, blocks);
  return Reduce(problem, ResidualsOf(problem, blocks), blocks, options, fault);
}

std::optional<Marginal> TrySummarize(const ceres::Problem& problem, std::span<double* const> kept,
                                     const MarginalizationOptions& options, std::string* fault) {
  options.Validate();
  RequireBlocks(problem, {kept.begin(), kept.end()});
  const std::unordered_set<const double*> stay(kept.begin(), kept.end());
  std::vector<ceres::ResidualBlockId> residuals;
  problem.GetResidualBlocks(&residuals);
  // In the order of occurrence: Problem::GetParameterBlocks is ordered by address.
  std::unordered_set<const double*> met;
  std::vector<double*> blocks, removed;
  for (const ceres::ResidualBlockId residual : residuals) {
    problem.GetParameterBlocksForResidualBlock(residual, &blocks);
    for (double* block : blocks) {
      if (stay.count(block) == 0 && met.insert(block).second) removed.push_back(block);
    }
  }
  return Reduce(problem, residuals, removed, options, fault);
}

}  // namespace internal

}  // namespace highwall
