#include <highwall/core/factor_graph.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>

#include "factor_graph_impl.h"

namespace highwall {
namespace {

std::uint32_t NextGraphNumber() {
  static std::atomic<std::uint32_t> last = 0;
  return ++last;
}

// Returns the slot to fill next: a freed one, or a new one at the end.
template <class Slot>
std::uint32_t TakeSlot(std::vector<Slot>* slots, std::vector<std::uint32_t>* free) {
  if (free->empty()) {
    slots->emplace_back();
    return static_cast<std::uint32_t>(slots->size() - 1);
  }
  const std::uint32_t index = free->back();
  free->pop_back();
  return index;
}

}  // namespace

FactorGraph::FactorGraph() : impl_(std::make_unique<Impl>(NextGraphNumber())) {}
FactorGraph::~FactorGraph() = default;
FactorGraph::FactorGraph(FactorGraph&&) noexcept = default;
FactorGraph& FactorGraph::operator=(FactorGraph&&) noexcept = default;

VariableId FactorGraph::AddBlock(std::span<const double> values, MakeManifold make_manifold,
                                 const std::type_info& type, bool landmark) {
  HIGHWALL_REQUIRE(
      std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }),
      "FactorGraph::AddVariable: the value must be finite");
  ceres::Manifold* const manifold =
      impl_->ManifoldOf(make_manifold, static_cast<int>(values.size()));
  const std::uint32_t index = TakeSlot(&impl_->variables, &impl_->free_variables);
  Impl::VariableSlot& slot = impl_->variables[index];
  slot.block = impl_->blocks.Take(values.size());
  std::copy(values.begin(), values.end(), slot.block);
  slot.size = static_cast<int>(values.size());
  slot.tangent_size = manifold != nullptr ? manifold->TangentSize() : slot.size;
  slot.manifold = manifold;
  slot.landmark = landmark;
  slot.fixed = false;
  slot.in_problem = false;
  slot.type = &type;
  ++slot.generation;
  const VariableId id{index, slot.generation, impl_->number};
  if (landmark) {
    impl_->pending_variables.push_back(id);
  } else {
    impl_->Enter(id);
  }
  return id;
}

void FactorGraph::SetBlock(const VariableId& variable, std::span<const double> values) {
  HIGHWALL_REQUIRE(
      std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }),
      "FactorGraph::SetValue: the value must be finite");
  std::copy(values.begin(), values.end(), MutableBlock(variable));
}

void FactorGraph::Remove(const VariableId& variable) {
  const std::vector<FactorId> factors = impl_->At(variable).factors;
  Suspend(factors);
  for (const FactorId& factor : factors) RemoveFactor(factor);
  Impl::VariableSlot& slot = impl_->variables[variable.index];
  if (slot.in_problem) {
    impl_->problem.RemoveParameterBlock(slot.block);
    impl_->by_block.erase(slot.block);
  }
  impl_->blocks.Return(slot.block, static_cast<std::size_t>(slot.size));
  slot.block = nullptr;
  slot.factors = {};
  impl_->free_variables.push_back(variable.index);
}

void FactorGraph::Fix(const VariableId& variable) {
  const double* const block = impl_->At(variable).block;
  impl_->variables[variable.index].fixed = true;
  if (impl_->At(variable).in_problem) impl_->problem.SetParameterBlockConstant(block);
}

void FactorGraph::Unfix(const VariableId& variable) {
  double* const block = impl_->At(variable).block;
  impl_->variables[variable.index].fixed = false;
  if (impl_->At(variable).in_problem) impl_->problem.SetParameterBlockVariable(block);
}

bool FactorGraph::IsFixed(const VariableId& variable) const {
  return impl_->At(variable).fixed;
}

FactorId FactorGraph::AddFactorToBlocks(std::shared_ptr<ceres::CostFunction> factor,
                                        std::shared_ptr<ceres::LossFunction> loss,
                                        std::span<const VariableId> variables) {
  impl_->RequireFit(factor.get(), variables);
  const std::uint32_t index = TakeSlot(&impl_->factors, &impl_->free_factors);
  Impl::FactorSlot& slot = impl_->factors[index];
  ++slot.generation;
  slot.factor = std::move(factor);
  slot.loss = std::move(loss);
  slot.joins_landmarks =
      std::count_if(variables.begin(), variables.end(),
                    [&](const VariableId& v) { return impl_->variables[v.index].landmark; }) > 1;
  slot.variables.Assign(variables);
  impl_->Attach(slot);
  return impl_->IdOf(slot);
}

void FactorGraph::RemoveFactor(const FactorId& factor) {
  const FactorId id = factor;  // `factor` may refer to an element of FactorsOf(), which changes
  if (impl_->Contains(id)) {
    impl_->Detach(impl_->factors[id.index]);
    for (const VariableId& variable : impl_->factors[id.index].variables) {
      std::erase(impl_->variables[variable.index].factors, id);
    }
  }
  Impl::FactorSlot& slot = impl_->AtSuspended(id);
  slot.state = Impl::FactorState::kFree;
  slot.variables.Clear();
  slot.guarded.reset();
  slot.factor.reset();
  slot.loss.reset();
  impl_->free_factors.push_back(id.index);
}

std::vector<FactorId> FactorGraph::Suspend(std::span<const FactorId> factors) {
  std::vector<FactorId> suspended;
  std::vector<VariableId> touched;
  std::vector<bool> known(impl_->variables.size(), false);
  for (const FactorId& factor : factors) {
    if (!impl_->Contains(factor)) continue;
    Impl::FactorSlot& slot = impl_->factors[factor.index];
    impl_->Detach(slot);
    suspended.push_back(factor);
    for (const VariableId& id : slot.variables) {
      if (known[id.index]) continue;
      known[id.index] = true;
      touched.push_back(id);
    }
  }
  for (const VariableId& id : touched) impl_->ForgetDetached(id);
  return suspended;
}

void FactorGraph::Resume(const FactorId& factor) {
  impl_->Attach(impl_->AtSuspended(factor));
}

bool FactorGraph::Contains(const VariableId& variable) const {
  return impl_->Contains(variable);
}

bool FactorGraph::Contains(const FactorId& factor) const {
  return impl_->Contains(factor);
}

std::size_t FactorGraph::NumVariables() const {
  return impl_->variables.size() - impl_->free_variables.size();
}

std::size_t FactorGraph::NumFactors() const {
  return impl_->active_factors;
}

const std::vector<FactorId>& FactorGraph::FactorsOf(const VariableId& variable) const {
  return impl_->At(variable).factors;
}

std::vector<VariableId> FactorGraph::VariablesOf(const FactorId& factor) const {
  const internal::VariableList& variables = impl_->At(factor).variables;
  return {variables.begin(), variables.end()};
}

const ceres::CostFunction& FactorGraph::Factor(const FactorId& factor) const {
  return *impl_->At(factor).factor;
}

std::string FactorGraph::FaultOf(const FactorId& factor) const {
  return impl_->FaultOf(impl_->At(factor));
}

double FactorGraph::SquaredError(const FactorId& factor) const {
  const std::optional<double> error = TrySquaredError(factor);
  HIGHWALL_REQUIRE(error, "FactorGraph::SquaredError: " + FaultOf(factor));
  return *error;
}

std::optional<double> FactorGraph::TrySquaredError(const FactorId& factor) const {
  const Impl::FactorSlot& slot = impl_->At(factor);
  // Of almost all factors; no memory is allocated for these.
  constexpr std::size_t kFewRows = 16, kFewVariables = 8;
  const auto rows = static_cast<std::size_t>(slot.factor->num_residuals());
  const std::size_t variables = slot.variables.size();
  alignas(EIGEN_DEFAULT_ALIGN_BYTES) std::array<double, kFewRows> few_rows;
  std::array<const double*, kFewVariables> few_variables;
  Eigen::VectorXd many_rows(rows > kFewRows ? static_cast<Eigen::Index>(rows) : 0);
  std::vector<const double*> many_variables(variables > kFewVariables ? variables : 0);
  double* const residuals = rows > kFewRows ? many_rows.data() : few_rows.data();
  const double** const parameters =
      variables > kFewVariables ? many_variables.data() : few_variables.data();
  // A row that the factor leaves as it is makes it one that cannot be evaluated.
  std::fill_n(residuals, rows, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < variables; ++i) parameters[i] = impl_->At(slot.variables[i]).block;
  if (!internal::EvaluatesWell(*slot.factor, parameters, residuals, nullptr)) return std::nullopt;
  return Eigen::Map<const Eigen::VectorXd, Eigen::AlignedMax>(residuals,
                                                              static_cast<Eigen::Index>(rows))
      .squaredNorm();
}

double FactorGraph::Cost() const {
  impl_->CompleteProblem();
  double cost = 0.0;
  const bool ok = impl_->problem.Evaluate({}, &cost, nullptr, nullptr, nullptr);
  HIGHWALL_REQUIRE(ok, "FactorGraph::Cost: " + impl_->FirstFault());
  return cost;
}

const double* FactorGraph::Block(const VariableId& variable) const {
  return impl_->At(variable).block;
}

double* FactorGraph::MutableBlock(const VariableId& variable) {
  return impl_->At(variable).block;
}

VariableId FactorGraph::FindVariable(const double* block) const {
  impl_->CompleteProblem();
  const auto found = impl_->by_block.find(block);
  HIGHWALL_REQUIRE(found != impl_->by_block.end(), "FactorGraph: the graph has no such block");
  return found->second;
}

ceres::Problem& FactorGraph::problem() {
  impl_->CompleteProblem();
  return impl_->problem;
}

const ceres::Problem& FactorGraph::problem() const {
  impl_->CompleteProblem();
  return impl_->problem;
}

}  // namespace highwall
