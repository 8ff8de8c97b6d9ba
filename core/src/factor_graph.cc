#include <highwall/core/factor_graph.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <unordered_map>

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <highwall/core/error.h>
#include <highwall/internal/quiet_glog.h>
#include "graph_covariance.h"
#include "guarded_factor.h"
#include "projected_problem.h"
#include "solve_callback.h"

namespace highwall {
namespace {

// Reduced systems up to this many tangent dimensions are solved densely.
constexpr int kMaxDenseDimensions = 400;

struct VariableSlot {
  std::unique_ptr<double[]> block;  // null: free
  int size = 0;
  std::uint32_t generation = 0;
  bool landmark = false;
  const std::type_info* type = nullptr;
  std::vector<FactorId> factors;
};

struct FactorSlot {
  ceres::ResidualBlockId residual = nullptr;  // null: free or suspended
  std::uint32_t generation = 0;
  bool joins_landmarks = false;       // more than one
  std::vector<VariableId> variables;  // empty: free
  std::shared_ptr<ceres::CostFunction> factor;
  std::unique_ptr<internal::GuardedFactor> guarded;
  std::shared_ptr<ceres::LossFunction> loss;
};

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

ceres::LinearSolverType ToCeres(LinearSolver solver, bool has_landmarks, int other_dimensions) {
  switch (solver) {
    case LinearSolver::kDenseCholesky:
      return ceres::DENSE_NORMAL_CHOLESKY;
    case LinearSolver::kSparseCholesky:
      return ceres::SPARSE_NORMAL_CHOLESKY;
    case LinearSolver::kDenseSchur:
      return ceres::DENSE_SCHUR;
    case LinearSolver::kSparseSchur:
      return ceres::SPARSE_SCHUR;
    case LinearSolver::kVariableProjection:  // without landmarks
    case LinearSolver::kAuto:
      break;
  }
  const bool dense = other_dimensions <= kMaxDenseDimensions;
  if (has_landmarks) return dense ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  return dense ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
}

ceres::Solver::Options ToCeres(const SolveOptions& options) {
  ceres::Solver::Options solver;
  solver.max_num_iterations = options.max_iterations;
  solver.max_solver_time_in_seconds = options.max_seconds;
  solver.num_threads = options.threads;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = options.gradient_tolerance;
  solver.parameter_tolerance = options.parameter_tolerance;
  solver.initial_trust_region_radius = options.initial_trust_region_radius;
  solver.max_trust_region_radius =
      std::max(solver.max_trust_region_radius, options.initial_trust_region_radius);
  solver.logging_type = ceres::SILENT;
  return solver;
}

SolveStatus ToStatus(ceres::TerminationType type) {
  switch (type) {
    case ceres::CONVERGENCE:
      return SolveStatus::kConverged;
    case ceres::NO_CONVERGENCE:
      return SolveStatus::kLimit;
    case ceres::USER_SUCCESS:
      return SolveStatus::kStopped;
    default:
      return SolveStatus::kFailed;
  }
}

}  // namespace

struct FactorGraph::Impl {
  const std::uint32_t number = NextGraphNumber();
  mutable internal::FactorFaults faults;
  // Declared before the problem, which refers to them until it is destroyed.
  std::vector<std::pair<MakeManifold, std::unique_ptr<ceres::Manifold>>> manifolds;
  std::vector<VariableSlot> variables;
  std::vector<FactorSlot> factors;
  std::vector<std::uint32_t> free_variables, free_factors;
  std::unordered_map<const double*, VariableId> by_block;
  // Blocks of removed variables, by size. Ceres 2.1 stores every address that was ever added: if
  // addresses are reused, memory does not grow.
  std::unordered_map<std::size_t, std::vector<std::unique_ptr<double[]>>> spare_blocks;
  ceres::Problem problem{internal::SharedProblemOptions()};
  internal::VariableProjection::Memory projection_memory;

  bool Contains(const VariableId& id) const {
    return id.graph == number && id.index < variables.size() &&
           variables[id.index].block != nullptr && variables[id.index].generation == id.generation;
  }
  bool Contains(const FactorId& id) const {
    return id.graph == number && id.index < factors.size() &&
           factors[id.index].residual != nullptr && factors[id.index].generation == id.generation;
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

  // Adds the factor of the slot to the problem.
  void Attach(FactorSlot& slot) {
    std::vector<double*> blocks;
    blocks.reserve(slot.variables.size());
    for (const VariableId& id : slot.variables) blocks.push_back(At(id).block.get());
    slot.residual = problem.AddResidualBlock(slot.guarded.get(), slot.loss.get(), blocks);
    for (const VariableId& id : slot.variables) variables[id.index].factors.push_back(IdOf(slot));
  }
  void Detach(FactorSlot& slot) {
    problem.RemoveResidualBlock(slot.residual);
    slot.residual = nullptr;
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
                         factors[id.index].residual == nullptr &&
                         !factors[id.index].variables.empty(),
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
    for (const VariableId& id : slot.variables) parameters.push_back(At(id).block.get());
    const std::string fault = internal::FaultOf(*slot.factor, parameters);
    return fault.empty() ? fault : Describe(slot) + ", " + fault;
  }
  // Returns the first fault of a factor: at the current values, else at the solver's last trial.
  std::string FirstFault() const {
    for (const FactorSlot& slot : factors) {
      if (slot.residual == nullptr) continue;
      const std::string fault = FaultOf(slot);
      if (!fault.empty()) return fault;
    }
    for (const FactorSlot& slot : factors) {
      if (slot.residual == nullptr || slot.factor.get() != faults.last) continue;
      return Describe(slot) + ", could not be evaluated where a step led";
    }
    return "";
  }

  // Returns the blocks that are estimated.
  std::vector<double*> Unknown() const {
    std::vector<double*> unknown;
    for (const VariableSlot& slot : variables) {
      double* const block = slot.block.get();
      if (block != nullptr && !problem.IsParameterBlockConstant(block)) unknown.push_back(block);
    }
    return unknown;
  }
  struct Unknowns {
    std::vector<double*> landmarks, others;
  };
  Unknowns UnknownsByKind() const {
    Unknowns unknowns;
    for (const VariableSlot& slot : variables) {
      double* const block = slot.block.get();
      if (block == nullptr || problem.IsParameterBlockConstant(block)) continue;
      (slot.landmark ? unknowns.landmarks : unknowns.others).push_back(block);
    }
    return unknowns;
  }
  int TangentSize(const std::vector<double*>& blocks) const {
    int size = 0;
    for (const double* const block : blocks) size += problem.ParameterBlockTangentSize(block);
    return size;
  }
  // Empty if one of `ids` is a landmark that is estimated.
  std::optional<Eigen::MatrixXd> CovarianceOf(std::span<const VariableId> ids,
                                              const internal::ProjectedProblem& projected,
                                              const Unknowns& unknowns) const {
    std::vector<const double*> wanted;
    for (const VariableId& id : ids) {
      const double* const block = At(id).block.get();
      if (At(id).landmark && !problem.IsParameterBlockConstant(block)) return std::nullopt;
      wanted.push_back(block);
    }
    return projected.Covariance(unknowns.others, wanted);
  }
  // Describes a factor that cannot be evaluated, or else an unobservable variable and the first of
  // its factors; empty if there is neither.
  std::string FirstUndetermined() {
    const auto undetermined = internal::FindUndetermined(problem, Unknown());
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

  SolveSummary Summarize(const ceres::Solver::Summary& ceres_summary) {
    SolveSummary summary;
    summary.status = ToStatus(ceres_summary.termination_type);
    summary.message = ceres_summary.message;
    if (!summary.IsUsable()) {
      const std::string fault = faults.last != nullptr ? FirstFault() : FirstUndetermined();
      if (!fault.empty()) summary.message = fault;
    }
    summary.initial_cost = ceres_summary.initial_cost;
    summary.final_cost = ceres_summary.final_cost;
    summary.iterations =
        std::max(0, ceres_summary.num_successful_steps) +  // -1 if there was nothing to solve
        std::max(0, ceres_summary.num_unsuccessful_steps);
    summary.rejected_steps = std::max(0, ceres_summary.num_unsuccessful_steps);
    summary.seconds = ceres_summary.total_time_in_seconds;
    return summary;
  }

  // Returns true if a factor connects two landmarks that are not fixed.
  bool LandmarksDependOnEachOther() const {
    return std::any_of(factors.begin(), factors.end(), [&](const FactorSlot& slot) {
      if (slot.residual == nullptr || !slot.joins_landmarks) return false;
      std::vector<double*> blocks;
      problem.GetParameterBlocksForResidualBlock(slot.residual, &blocks);
      return std::count_if(blocks.begin(), blocks.end(), [&](const double* block) {
               return At(by_block.at(block)).landmark && !problem.IsParameterBlockConstant(block);
             }) > 1;
    });
  }

  std::unique_ptr<double[]> TakeBlock(std::size_t size) {
    std::vector<std::unique_ptr<double[]>>& spare = spare_blocks[size];
    if (spare.empty()) return std::make_unique<double[]>(size);
    std::unique_ptr<double[]> block = std::move(spare.back());
    spare.pop_back();
    return block;
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

FactorGraph::FactorGraph() : impl_(std::make_unique<Impl>()) {}
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
  VariableSlot& slot = impl_->variables[index];
  slot.block = impl_->TakeBlock(values.size());
  std::copy(values.begin(), values.end(), slot.block.get());
  slot.size = static_cast<int>(values.size());
  slot.landmark = landmark;
  slot.type = &type;
  ++slot.generation;
  impl_->problem.AddParameterBlock(slot.block.get(), slot.size, manifold);
  const VariableId id{index, slot.generation, impl_->number};
  impl_->by_block.emplace(slot.block.get(), id);
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
  VariableSlot& slot = impl_->variables[variable.index];
  impl_->problem.RemoveParameterBlock(slot.block.get());
  impl_->by_block.erase(slot.block.get());
  impl_->spare_blocks[static_cast<std::size_t>(slot.size)].push_back(std::move(slot.block));
  slot.factors = {};
  impl_->free_variables.push_back(variable.index);
}

void FactorGraph::Fix(const VariableId& variable) {
  impl_->problem.SetParameterBlockConstant(impl_->At(variable).block.get());
}

void FactorGraph::Unfix(const VariableId& variable) {
  impl_->problem.SetParameterBlockVariable(impl_->At(variable).block.get());
}

bool FactorGraph::IsFixed(const VariableId& variable) const {
  return impl_->problem.IsParameterBlockConstant(impl_->At(variable).block.get());
}

FactorId FactorGraph::AddFactorToBlocks(std::shared_ptr<ceres::CostFunction> factor,
                                        std::shared_ptr<ceres::LossFunction> loss,
                                        std::span<const VariableId> variables) {
  impl_->RequireFit(factor.get(), variables);
  const std::uint32_t index = TakeSlot(&impl_->factors, &impl_->free_factors);
  FactorSlot& slot = impl_->factors[index];
  ++slot.generation;
  slot.factor = std::move(factor);
  slot.guarded = std::make_unique<internal::GuardedFactor>(*slot.factor, &impl_->faults);
  slot.loss = std::move(loss);
  slot.joins_landmarks =
      std::count_if(variables.begin(), variables.end(),
                    [&](const VariableId& v) { return impl_->variables[v.index].landmark; }) > 1;
  slot.variables.assign(variables.begin(), variables.end());
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
  FactorSlot& slot = impl_->AtSuspended(id);
  slot.variables.clear();
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
    FactorSlot& slot = impl_->factors[factor.index];
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
  return static_cast<std::size_t>(impl_->problem.NumResidualBlocks());
}

const std::vector<FactorId>& FactorGraph::FactorsOf(const VariableId& variable) const {
  return impl_->At(variable).factors;
}

const std::vector<VariableId>& FactorGraph::VariablesOf(const FactorId& factor) const {
  return impl_->At(factor).variables;
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
  double cost = 0.0;
  const bool ok = impl_->problem.EvaluateResidualBlock(
      impl_->At(factor).residual, /*apply_loss_function=*/false, &cost, nullptr, nullptr);
  return ok ? std::optional(2.0 * cost) : std::nullopt;
}

double FactorGraph::Cost() const {
  double cost = 0.0;
  const bool ok = impl_->problem.Evaluate({}, &cost, nullptr, nullptr, nullptr);
  HIGHWALL_REQUIRE(ok, "FactorGraph::Cost: " + impl_->FirstFault());
  return cost;
}

SolveSummary FactorGraph::Solve(const SolveOptions& options) {
  std::optional<Eigen::MatrixXd> none;
  return SolveWithCovariance(options, {}, &none);
}

SolveSummary FactorGraph::SolveWithCovariance(const SolveOptions& options,
                                              std::span<const VariableId> variables,
                                              std::optional<Eigen::MatrixXd>* covariance) {
  options.Validate();
  covariance->reset();
  const Impl::Unknowns unknowns = impl_->UnknownsByKind();
  const bool has_landmarks = !unknowns.landmarks.empty();
  const int dimensions = impl_->TangentSize(unknowns.others);
  const bool project =
      options.linear_solver == LinearSolver::kVariableProjection && has_landmarks && dimensions > 0;
  ceres::Solver::Options solver = ToCeres(options);
  solver.linear_solver_type = ToCeres(options.linear_solver, has_landmarks && !project, dimensions);
  // The choice of eliminated blocks is left to Ceres, which finds the landmarks by itself: it would
  // sort a given set by address, and runs would no longer be bit-identical.
  if ((project || ceres::IsSchurType(solver.linear_solver_type)) &&
      impl_->LandmarksDependOnEachOther()) {
    SolveSummary refused;
    refused.message = "a factor joins two landmarks: they are not an independent set";
    return refused;
  }

  internal::SolveCallback callback(options, impl_->faults, project);
  solver.callbacks.push_back(&callback);
  std::optional<internal::ProjectedProblem> projected;
  if (project) {
    projected.emplace(impl_->problem, unknowns.landmarks, &impl_->faults,
                      &impl_->projection_memory);
  }
  ceres::Solver::Summary ceres_summary;
  impl_->faults.last = nullptr;
  impl_->faults.must_stop = false;
  impl_->faults.solving = true;
  ++impl_->faults.solve;
  {
    const internal::QuietGlog quiet;
    if (projected) {
      projected->Solve(solver, &ceres_summary);
    } else {
      ceres::Solve(solver, &impl_->problem, &ceres_summary);
    }
  }
  impl_->faults.solving = false;
  SolveSummary summary = impl_->Summarize(ceres_summary);
  if (callback.converged() && summary.IsUsable()) {
    summary.status = SolveStatus::kConverged;
    summary.message = "the last step was foretold to gain less than function_tolerance";
  }
  if (projected && !variables.empty() && summary.IsUsable()) {
    *covariance = impl_->CovarianceOf(variables, *projected, unknowns);
  }
  return summary;
}

std::optional<Eigen::MatrixXd> FactorGraph::Covariance(
    std::span<const VariableId> variables) const {
  std::vector<double*> wanted;
  for (const VariableId& id : variables) wanted.push_back(impl_->At(id).block.get());
  return internal::TangentCovariance(impl_->problem, impl_->Unknown(), wanted);
}

std::string FactorGraph::Undetermined() const {
  return impl_->FirstUndetermined();
}

std::optional<Eigen::MatrixXd> FactorGraph::ReducedCovariance(
    std::span<const VariableId> variables) const {
  const Impl::Unknowns unknowns = impl_->UnknownsByKind();
  if (unknowns.landmarks.empty() || impl_->LandmarksDependOnEachOther()) return std::nullopt;
  impl_->faults.last = nullptr;
  const internal::ProjectedProblem projected(impl_->problem, unknowns.landmarks, &impl_->faults,
                                             &impl_->projection_memory);
  return impl_->CovarianceOf(variables, projected, unknowns);
}

const double* FactorGraph::Block(const VariableId& variable) const {
  return impl_->At(variable).block.get();
}

double* FactorGraph::MutableBlock(const VariableId& variable) {
  return impl_->At(variable).block.get();
}

VariableId FactorGraph::FindVariable(const double* block) const {
  const auto found = impl_->by_block.find(block);
  HIGHWALL_REQUIRE(found != impl_->by_block.end(), "FactorGraph: the graph has no such block");
  return found->second;
}

ceres::Problem& FactorGraph::problem() {
  return impl_->problem;
}

const ceres::Problem& FactorGraph::problem() const {
  return impl_->problem;
}

}  // namespace highwall
