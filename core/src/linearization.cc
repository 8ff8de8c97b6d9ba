#include "linearization.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <highwall/core/error.h>
#include "guarded_factor.h"

namespace highwall::internal {
namespace {

// sqrt(rho'(|r|^2)): scales residual and Jacobian so that gradient and Gauss-Newton matrix are
// those of the loss (Eq. 2), as Ceres does wherever rho'' <= 0.
double LossWeight(const ceres::LossFunction* loss, const Eigen::VectorXd& r) {
  if (loss == nullptr) return 1.0;
  double rho[3];
  loss->Evaluate(r.squaredNorm(), rho);
  return std::sqrt(std::max(0.0, rho[1]));
}

}  // namespace

bool Linearization::Evaluate(const ceres::CostFunction& cost,
                             const std::vector<const double*>& parameters, bool with_jacobians,
                             Evaluation* out) {
  try {
    return EvaluateUnguarded(cost, parameters, with_jacobians, out);
  } catch (...) {  // as GuardedFactor
    return false;
  }
}

bool Linearization::EvaluateUnguarded(const ceres::CostFunction& cost,
                                      const std::vector<const double*>& parameters,
                                      bool with_jacobians, Evaluation* out) {
  out->r.resize(cost.num_residuals());
  if (!with_jacobians) return cost.Evaluate(parameters.data(), out->r.data(), nullptr);
  const std::size_t count = parameters.size();
  out->J.resize(std::max(out->J.size(), count));
  scratch_.jacobians.assign(count, nullptr);
  for (std::size_t i = 0; i < count; ++i) {
    if (scratch_.indices[i] < 0) continue;
    out->J[i].resize(cost.num_residuals(), cost.parameter_block_sizes()[i]);
    scratch_.jacobians[i] = out->J[i].data();
  }
  if (!cost.Evaluate(parameters.data(), out->r.data(), scratch_.jacobians.data())) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (scratch_.indices[i] >= 0 && !out->J[i].allFinite()) return false;
  }
  return true;
}

int Linearization::IndexOf(double* block) {
  const auto found = index_.find(block);
  if (found != index_.end()) return found->second;
  int index = -1;
  if (!problem_.IsParameterBlockConstant(block)) {
    index = static_cast<int>(blocks_.size());
    blocks_.push_back(MakeBlock(block));
  }
  index_.emplace(block, index);
  return index;
}

std::vector<int> Linearization::TangentSizes() const {
  std::vector<int> sizes;
  sizes.reserve(blocks_.size());
  for (const LinearBlock& block : blocks_) sizes.push_back(block.tangent_size);
  return sizes;
}

Linearization::Linearization(const ceres::Problem& problem, const MarginalizationOptions& options)
    : problem_(problem) {
  if (!options.first_estimate_jacobians) return;
  std::vector<ceres::ResidualBlockId> residuals;
  problem.GetResidualBlocks(&residuals);
  std::vector<double*> values;
  for (const ceres::ResidualBlockId residual : residuals) {
    const auto* prior = dynamic_cast<const MarginalPrior*>(
        &Unguarded(*problem.GetCostFunctionForResidualBlock(residual)));
    if (prior == nullptr) continue;
    problem.GetParameterBlocksForResidualBlock(residual, &values);
    for (std::size_t i = 0; i < values.size(); ++i) {
      first_estimates_.emplace(values[i], &prior->blocks()[i].linearization_point);
    }
  }
  for (const double* block : options.relinearized) first_estimates_.erase(block);
}

void Linearization::Fail(const std::string& why) {
  if (fault_.empty()) fault_ = why;
}

LinearBlock Linearization::MakeBlock(double* values) {
  LinearBlock block;
  block.values = values;
  block.size = problem_.ParameterBlockSize(values);
  block.tangent_size = problem_.ParameterBlockTangentSize(values);
  block.manifold = problem_.GetManifold(values);
  block.point.assign(values, values + block.size);
  const auto first = first_estimates_.find(values);
  if (first != first_estimates_.end() && *first->second != block.point) {
    block.point = *first->second;
    block.moved = true;
  }
  if (block.manifold != nullptr) {
    block.plus.resize(block.size, block.tangent_size);
    if (!block.manifold->PlusJacobian(block.point.data(), block.plus.data())) {
      Fail("Marginalize: a manifold cannot be linearized");
    }
  }
  if (!block.moved) return block;
  block.offset.resize(block.tangent_size);
  if (block.manifold != nullptr) {
    if (!block.manifold->Minus(values, block.point.data(), block.offset.data())) {
      Fail("Marginalize: a manifold cannot compare a block with its first estimate");
    }
  } else {
    for (int k = 0; k < block.size; ++k) {
      block.offset[k] = values[k] - block.point[static_cast<std::size_t>(k)];
    }
  }
  return block;
}

std::optional<Rows> Linearization::Linearize(ceres::ResidualBlockId residual) {
  const ceres::CostFunction& cost = Unguarded(*problem_.GetCostFunctionForResidualBlock(residual));
  auto& [values, indices, present, points, jacobians, order, now, first] = scratch_;
  problem_.GetParameterBlocksForResidualBlock(residual, &values);
  indices.clear(), order.clear();
  int columns = 0;
  bool moved = false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int index = IndexOf(values[i]);
    indices.push_back(index);
    if (index < 0) continue;
    order.emplace_back(index, i);
    columns += blocks_[static_cast<std::size_t>(index)].tangent_size;
    moved |= blocks_[static_cast<std::size_t>(index)].moved;
  }
  if (!fault_.empty()) return std::nullopt;
  std::sort(order.begin(), order.end());
  present.assign(values.begin(), values.end());

  bool ok = Evaluate(cost, present, !moved, &now) && now.r.allFinite();
  if (ok && moved) {
    points = present;
    for (const auto& [index, i] : order) {
      points[i] = blocks_[static_cast<std::size_t>(index)].point.data();
    }
    // Otherwise the first estimate is outside of the factor's domain.
    ok = Evaluate(cost, points, true, &first) || Evaluate(cost, present, true, &first);
  }
  if (!ok) {
    Fail("Marginalize: a " + TypeName(typeid(cost)) + " cannot be evaluated");
    return std::nullopt;
  }
  const std::vector<RowMajor>& J = moved ? first.J : now.J;

  Rows rows;
  rows.matrix.resize(cost.num_residuals(), columns + 1);
  rows.matrix.col(columns) = now.r;
  rows.blocks.reserve(order.size());
  int column = 0;
  for (const auto& [index, i] : order) {
    const LinearBlock& block = blocks_[static_cast<std::size_t>(index)];
    rows.blocks.push_back(index);
    auto tangent = rows.matrix.middleCols(column, block.tangent_size);
    if (block.manifold != nullptr) {
      tangent.noalias() = J[i] * block.plus;
    } else {
      tangent = J[i];
    }
    if (block.moved) rows.matrix.col(columns) -= tangent * block.offset;  // Eq. 10
    column += block.tangent_size;
  }
  rows.matrix *= LossWeight(problem_.GetLossFunctionForResidualBlock(residual), now.r);  // Eq. 2
  return rows;
}

std::vector<ceres::ResidualBlockId> ResidualsOf(const ceres::Problem& problem,
                                                const std::vector<double*>& blocks) {
  // Not GetResidualBlocksForParameterBlock: its order depends on addresses, and without fast
  // removal it searches the whole problem for every block.
  const std::unordered_set<const double*> wanted(blocks.begin(), blocks.end());
  std::vector<ceres::ResidualBlockId> residuals;
  std::vector<double*> touched;
  problem.GetResidualBlocks(&residuals);
  std::erase_if(residuals, [&](ceres::ResidualBlockId residual) {
    problem.GetParameterBlocksForResidualBlock(residual, &touched);
    return std::none_of(touched.begin(), touched.end(),
                        [&](const double* block) { return wanted.count(block) > 0; });
  });
  return residuals;
}

void RequireBlocks(const ceres::Problem& problem, const std::vector<double*>& blocks) {
  std::unordered_set<const double*> seen;
  for (const double* block : blocks) {
    HIGHWALL_REQUIRE(problem.HasParameterBlock(block),
                     "Marginalize: a block is not in the problem");
    HIGHWALL_REQUIRE(seen.insert(block).second, "Marginalize: a block is given twice");
  }
}

}  // namespace highwall::internal
