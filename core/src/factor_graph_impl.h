#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <typeinfo>
#include <unordered_map>
#include <utility>
#include <vector>

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include "block_pool.h"
#include "graph_covariance.h"
#include "guarded_factor.h"
#include "landmark_problem.h"
#include "projected_problem.h"
#include "variable_list.h"

namespace highwall {
namespace internal {

struct VariableSlot {
  double* block = nullptr;  // of the pool; null: free
  int size = 0;
  int tangent_size = 0;
  ceres::Manifold* manifold = nullptr;  // null: Euclidean
  std::uint32_t generation = 0;
  bool landmark = false;
  bool fixed = false;
  bool in_problem = false;
  const std::type_info* type = nullptr;
  std::vector<FactorId> factors;
};

constexpr std::size_t kUsualFactors = 8;  // of a landmark

enum class FactorState { kFree, kActive, kSuspended };

struct FactorSlot {
  FactorState state = FactorState::kFree;
  ceres::ResidualBlockId residual = nullptr;  // null: not in the problem
  std::uint32_t generation = 0;
  bool joins_landmarks = false;  // more than one
  internal::VariableList variables;
  std::shared_ptr<ceres::CostFunction> factor;
  std::unique_ptr<internal::GuardedFactor> guarded;  // null before it was in the problem
  std::shared_ptr<ceres::LossFunction> loss;
};

}  // namespace internal

struct FactorGraph::Impl {
  using VariableSlot = internal::VariableSlot;
  using FactorSlot = internal::FactorSlot;
  using FactorState = internal::FactorState;

  explicit Impl(std::uint32_t graph_number) : number(graph_number) {}

  const std::uint32_t number;  // unique
  mutable internal::FactorFaults faults;
  // Declared before the problem, which refers to them until it is destroyed.
  std::vector<std::pair<MakeManifold, std::unique_ptr<ceres::Manifold>>> manifolds;
  std::vector<VariableSlot> variables;
  std::vector<FactorSlot> factors;
  std::vector<std::uint32_t> free_variables, free_factors;
  std::size_t active_factors = 0;
  internal::BlockPool blocks;
  // Landmarks and factors enter the problem when it is needed as a whole (CompleteProblem()): in
  // variable projection neither landmarks nor their factors are in the problem of Ceres, and a
  // map has so many that adding and deleting them takes a third of the time of an adjustment.
  std::vector<VariableId> pending_variables;
  std::vector<std::uint32_t> pending_factors;  // in the order in which they became active
  std::unordered_map<const double*, VariableId> by_block;  // of the variables in the problem
  ceres::Problem problem{internal::SharedProblemOptions()};
  internal::VariableProjection::Memory projection_memory;

  bool Contains(const VariableId& id) const {
    return id.graph == number && id.index < variables.size() &&
           variables[id.index].block != nullptr && variables[id.index].generation == id.generation;
  }
  bool Contains(const FactorId& id) const {
    return id.graph == number && id.index < factors.size() &&
           factors[id.index].state == FactorState::kActive &&
           factors[id.index].generation == id.generation;
  }
  const VariableSlot& At(const VariableId& id) const {
    HIGHWALL_REQUIRE(id.graph == 0 || id.graph == number,
                     "FactorGraph: the variable belongs to another graph");
    HIGHWALL_REQUIRE(Contains(id), "FactorGraph: the variable is not in the graph");
    return variables[id.index];
  }
  const FactorSlot& At(const FactorId& id) const {
    HIGHWALL_REQUIRE(id.graph == 0 || id.graph == number,
                     "FactorGraph: the factor belongs to another graph");
    HIGHWALL_REQUIRE(Contains(id), "FactorGraph: the factor is not in the graph");
    return factors[id.index];
  }
  FactorId IdOf(const FactorSlot& slot) const {
    return {static_cast<std::uint32_t>(&slot - factors.data()), slot.generation, number};
  }

  void Attach(FactorSlot& slot) {
    slot.state = FactorState::kActive;
    ++active_factors;
    const FactorId factor = IdOf(slot);
    for (const VariableId& id : slot.variables) {
      std::vector<FactorId>& of_variable = variables[id.index].factors;
      if (of_variable.empty()) of_variable.reserve(internal::kUsualFactors);
      of_variable.push_back(factor);
    }
    pending_factors.push_back(factor.index);
  }
  void Detach(FactorSlot& slot) {
    if (slot.residual != nullptr) problem.RemoveResidualBlock(slot.residual);
    slot.residual = nullptr;
    slot.state = FactorState::kSuspended;
    --active_factors;
  }

  // Adds a variable or a factor to the problem.
  void Enter(const VariableId& id) {
    VariableSlot& slot = variables[id.index];
    if (slot.in_problem) return;
    slot.in_problem = true;
    problem.AddParameterBlock(slot.block, slot.size, slot.manifold);
    if (slot.fixed) problem.SetParameterBlockConstant(slot.block);
    by_block.emplace(slot.block, id);
  }
  void Enter(FactorSlot& slot) {
    std::vector<double*> of_factor;
    of_factor.reserve(slot.variables.size());
    for (const VariableId& id : slot.variables) {
      Enter(id);
      of_factor.push_back(variables[id.index].block);
    }
    if (slot.guarded == nullptr) {
      slot.guarded = std::make_unique<internal::GuardedFactor>(*slot.factor, &faults);
    }
    slot.residual = problem.AddResidualBlock(slot.guarded.get(), slot.loss.get(), of_factor);
  }
  // Adds what is missing in the problem, factors only if `is_needed(slot)`.
  template <class Predicate>
  void EnterPending(const Predicate& is_needed) {
    std::erase_if(pending_factors, [&](std::uint32_t index) {
      FactorSlot& slot = factors[index];
      if (slot.state != FactorState::kActive || slot.residual != nullptr) return true;
      if (!is_needed(slot)) return false;
      Enter(slot);
      return true;
    });
  }
  void CompleteProblem() {
    for (const VariableId& id : pending_variables) {
      if (Contains(id)) Enter(id);
    }
    pending_variables.clear();
    EnterPending([](const FactorSlot&) { return true; });
  }
  bool IsEstimatedLandmark(const VariableId& id) const {
    return variables[id.index].landmark && !variables[id.index].fixed;
  }
  // Splits the graph into its landmarks with their factors, and the other factors, which enter the
  // problem.
  internal::LandmarkProblem Split(std::vector<ceres::ResidualBlockId>* others) {
    std::erase_if(pending_variables, [&](const VariableId& id) {
      return !Contains(id) || variables[id.index].in_problem;
    });
    EnterPending([&](const FactorSlot& slot) {
      return std::ranges::none_of(slot.variables,
                                  [&](const VariableId& id) { return IsEstimatedLandmark(id); });
    });
    std::vector<internal::LandmarkProblemBuilder::Variable> described;
    described.reserve(variables.size());
    for (const VariableSlot& slot : variables) {
      described.push_back({{slot.block, slot.size, slot.tangent_size, slot.manifold},
                           slot.fixed,
                           slot.landmark && slot.block != nullptr});
    }
    internal::LandmarkProblemBuilder builder(std::move(described));
    for (const FactorSlot& slot : factors) {
      if (slot.state != FactorState::kActive) continue;
      if (!builder.Add(*slot.factor, slot.loss.get(), slot.variables)) {
        others->push_back(slot.residual);
      }
    }
    return builder.Finish();
  }

  // Removes detached factors from the factor list of a variable.
  void ForgetDetached(const VariableId& id) {
    std::erase_if(variables[id.index].factors,
                  [&](const FactorId& factor) { return !Contains(factor); });
  }
  // Returns the slot of a handle that may be suspended.
  FactorSlot& AtSuspended(const FactorId& id) {
    HIGHWALL_REQUIRE(id.graph == number && id.index < factors.size() &&
                         factors[id.index].generation == id.generation &&
                         factors[id.index].state == FactorState::kSuspended,
                     "FactorGraph: the factor is not suspended");
    return factors[id.index];
  }

  // Describes a factor by its type and by the indices and types of its variables.
  std::string Describe(const FactorSlot& slot) const {
    const ceres::CostFunction& factor = *slot.factor;
    std::string on;
    for (const VariableId& id : slot.variables) {
      on += (on.empty() ? " on variable " : ", variable ") + std::to_string(id.index) + " (" +
            internal::TypeName(*At(id).type) + ")";
    }
    return "factor " + std::to_string(IdOf(slot).index) + ", a " +
           internal::TypeName(typeid(factor)) + on;
  }
  std::string FaultOf(const FactorSlot& slot) const {
    std::vector<const double*> parameters;
    for (const VariableId& id : slot.variables) parameters.push_back(At(id).block);
    const std::string fault = internal::FaultOf(*slot.factor, parameters);
    return fault.empty() ? fault : Describe(slot) + ", " + fault;
  }
  // Returns the first fault of a factor: at the current values, else at the solver's last trial.
  std::string FirstFault() const {
    for (const FactorSlot& slot : factors) {
      if (slot.state != FactorState::kActive) continue;
      const std::string fault = FaultOf(slot);
      if (!fault.empty()) return fault;
    }
    for (const FactorSlot& slot : factors) {
      if (slot.state != FactorState::kActive || slot.factor.get() != faults.last) continue;
      return Describe(slot) + ", could not be evaluated where a step led";
    }
    return "";
  }

  // The blocks that are estimated.
  struct Unknowns {
    std::vector<double*> all, others;      // others: no landmarks
    int other_dimensions = 0;              // tangent space
    const std::type_info* type = nullptr;  // of the first of all
    bool are_of_one_type = true;
    bool HasLandmarks() const { return all.size() > others.size(); }
  };
  Unknowns FindUnknowns() const {
    Unknowns unknowns;
    for (const VariableSlot& slot : variables) {
      if (slot.block == nullptr || slot.fixed) continue;
      unknowns.all.push_back(slot.block);
      if (unknowns.type == nullptr) unknowns.type = slot.type;
      if (*slot.type != *unknowns.type) unknowns.are_of_one_type = false;
      if (slot.landmark) continue;
      unknowns.others.push_back(slot.block);
      unknowns.other_dimensions += slot.tangent_size;
    }
    return unknowns;
  }
  // Empty if one of `ids` is a landmark that is estimated.
  std::optional<Eigen::MatrixXd> CovarianceOf(std::span<const VariableId> ids,
                                              const internal::ProjectedProblem& projected,
                                              const Unknowns& unknowns) {
    std::vector<const double*> wanted;
    for (const VariableId& id : ids) {
      wanted.push_back(At(id).block);
      if (IsEstimatedLandmark(id)) return std::nullopt;
      Enter(id);  // a fixed landmark may not be in the problem yet
    }
    return projected.Covariance(unknowns.others, wanted);
  }
  // Describes a factor that cannot be evaluated, or else an unobservable variable and the first of
  // its factors; empty if there is neither.
  std::string FirstUndetermined() {
    CompleteProblem();
    const auto undetermined = internal::FindUndetermined(problem, FindUnknowns().all);
    if (!undetermined) return FirstFault();
    const double* const block = *undetermined;
    if (block == nullptr) return "";
    const VariableSlot& slot = At(by_block.at(block));
    const std::string name = "variable " + std::to_string(by_block.at(block).index) + " (" +
                             internal::TypeName(*slot.type) + ")";
    if (slot.factors.empty()) return name + " is in no factor: fix it, or add a prior";
    return name +
           " is not determined (singular): fix a variable, or add a prior; of its factors, " +
           Describe(At(slot.factors.front()));
  }

  SolveSummary Summarize(const ceres::Solver::Summary& ceres_summary);
  // Solves with the landmarks eliminated by a cost function.
  SolveSummary Run(const SolveOptions& options, ceres::Solver::Options solver,
                   internal::ProjectedProblem& projected);
  // Solves with all variables in the problem of Ceres.
  SolveSummary RunWhole(const SolveOptions& options, ceres::Solver::Options solver);
  // Continues a solve, whose summary is given, with all variables in the problem of Ceres.
  SolveSummary Continue(const SolveOptions& options, ceres::Solver::Options solver,
                        const SolveSummary& first);

  // Returns true if a factor connects two landmarks that are not fixed.
  bool LandmarksDependOnEachOther() const {
    return std::ranges::any_of(factors, [&](const FactorSlot& slot) {
      return slot.state == FactorState::kActive && slot.joins_landmarks &&
             std::ranges::count_if(
                 slot.variables, [&](const VariableId& id) { return IsEstimatedLandmark(id); }) > 1;
    });
  }

  // One manifold object per type of variable; null if Euclidean.
  ceres::Manifold* ManifoldOf(MakeManifold make, int size) {
    for (const auto& [key, manifold] : manifolds) {
      if (key == make) return manifold.get();
    }
    std::unique_ptr<ceres::Manifold> manifold = make();
    HIGHWALL_REQUIRE(manifold == nullptr || manifold->AmbientSize() == size,
                     "FactorGraph::AddVariable: the manifold is one of " +
                         std::to_string(manifold->AmbientSize()) + " doubles, the variable has " +
                         std::to_string(size));
    manifolds.emplace_back(make, std::move(manifold));
    return manifolds.back().second.get();
  }

  void RequireFit(const ceres::CostFunction* factor, std::span<const VariableId> ids) const {
    HIGHWALL_REQUIRE(factor != nullptr, "FactorGraph::AddFactor: the factor is null");
    HIGHWALL_REQUIRE(factor->num_residuals() > 0, "FactorGraph::AddFactor: no residuals");
    const std::vector<int>& sizes = factor->parameter_block_sizes();
    HIGHWALL_REQUIRE(sizes.size() == ids.size(),
                     "FactorGraph::AddFactor: the factor takes " + std::to_string(sizes.size()) +
                         " variables, given " + std::to_string(ids.size()));
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const int size = At(ids[i]).size;
      HIGHWALL_REQUIRE(size == sizes[i], "FactorGraph::AddFactor: block " + std::to_string(i) +
                                             " of the factor has size " + std::to_string(sizes[i]) +
                                             ", the variable has size " + std::to_string(size));
      HIGHWALL_REQUIRE(std::find(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(i),
                                 ids[i]) == ids.begin() + static_cast<std::ptrdiff_t>(i),
                       "FactorGraph::AddFactor: variable " + std::to_string(i) + " is given twice");
    }
  }
};

}  // namespace highwall
