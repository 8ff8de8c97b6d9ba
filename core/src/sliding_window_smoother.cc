#include <highwall/core/sliding_window_smoother.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include <ceres/problem.h>

#include <highwall/core/error.h>
#include <highwall/core/marginalization.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/stopwatch.h>
#include "graph_covariance.h"
#include "sliding_window_file.h"
#include "try_marginalize.h"

namespace highwall {
namespace {

bool IsFinite(const double* values, int count) {
  return std::all_of(values, values + count, [](double x) { return std::isfinite(x); });
}

}  // namespace

struct SlidingWindowSmoother::Impl {
  struct Info {
    VariableId id;  // generation 0: none
    Kind kind = Kind::kState;
    Stamp stamp = 0;
    const char* type = "";
  };
  using Values = std::vector<std::pair<VariableId, std::vector<double>>>;
  // Leaving variables and factors, removed provisionally until no step can fail any more.
  struct Leaving {
    std::vector<VariableId> variables;
    std::vector<FactorId> factors;  // suspended
    std::vector<FactorId> priors;   // that replace them
  };

  SlidingWindowOptions options;
  FactorGraph graph;
  std::vector<Info> infos;  // by VariableId::index
  std::map<Stamp, std::vector<VariableId>> states;
  // Added since the last update.
  std::vector<VariableId> new_variables;
  std::vector<FactorId> new_factors;
  // Durations in the last update [s], to be reserved from the budget.
  double iteration_seconds = 0.0;
  double shrink_seconds = 0.0;
  double covariance_seconds = 0.0;

  const Info& InfoOf(const VariableId& id) const { return infos[id.index]; }
  int SizeOf(const VariableId& id) const {
    return graph.problem().ParameterBlockSize(graph.Block(id));
  }
  template <class Predicate>
  std::vector<VariableId> Select(Predicate predicate) const;
  std::vector<double*> Blocks(const std::vector<VariableId>& ids);

  void RequireDistinct(std::span<const VariableId> ids) const;
  void Remove(const VariableId& id);
  Values Snapshot() const;
  void RollBack(const Values& values);

  std::string FaultOfNewFactors() const;
  std::string Solve(const Stopwatch& update, std::span<const VariableId> covariance_of,
                    UpdateReport* report);
  std::string FaultOfSolution() const;

  MarginalizationOptions PriorOptions() const;
  std::optional<Stamp> ChooseLeaving(UpdateReport* report, std::string* fault);
  std::optional<Stamp> LeastInformative(UpdateReport* report, std::string* fault);
  bool IsSeenFrom(const VariableId& landmark, Stamp stamp) const;
  std::vector<VariableId> LeavingLandmarks(Stamp stamp, Leaving* all, UpdateReport* report);
  std::string Leave(Stamp stamp, Leaving* all, UpdateReport* report);
  std::size_t Suspend(const std::vector<FactorId>& factors, Leaving* all);
  void TakeBack(const Leaving& all);
  std::string Shrink(UpdateReport* report);
};

const char* ToString(LeavingPolicy policy) {
  return policy == LeavingPolicy::kOldestFirst ? "oldest_first" : "least_information";
}

const char* ToString(LandmarkPolicy policy) {
  return policy == LandmarkPolicy::kKeepTracked ? "keep_tracked" : "marginalize";
}

void SlidingWindowOptions::Validate() const {
  const auto require = [](bool ok, const char* field, double value) {
    HIGHWALL_REQUIRE(ok, std::string("SlidingWindowOptions::") + field +
                             " is out of range: " + FixedText(value));
  };
  require(max_states >= 1, "max_states", max_states);
  require(max_seconds > 0.0, "max_seconds", max_seconds);
  require(budget_ms > 0.0, "budget_ms", budget_ms);
  require(protected_states >= 1, "protected_states", protected_states);
  require(max_error > 0.0, "max_error", max_error);
  marginalization.Validate();
  solve.Validate();
}

template <class Predicate>
std::vector<VariableId> SlidingWindowSmoother::Impl::Select(Predicate predicate) const {
  std::vector<VariableId> ids;
  for (const Info& info : infos) {
    if (graph.Contains(info.id) && predicate(info)) ids.push_back(info.id);
  }
  return ids;
}

std::vector<double*> SlidingWindowSmoother::Impl::Blocks(const std::vector<VariableId>& ids) {
  std::vector<double*> blocks;
  for (const VariableId& id : ids) blocks.push_back(graph.MutableBlock(id));
  return blocks;
}

void SlidingWindowSmoother::Impl::RequireDistinct(std::span<const VariableId> ids) const {
  std::set<const double*> blocks;
  for (const VariableId& id : ids) {
    HIGHWALL_REQUIRE(blocks.insert(graph.Block(id)).second,
                     "SlidingWindowSmoother: a variable of the covariance is given twice");
  }
}

void SlidingWindowSmoother::Impl::Remove(const VariableId& id) {
  graph.Remove(id);
  Info& info = infos[id.index];
  if (info.kind == Kind::kState) {
    const auto at = states.find(info.stamp);
    if (at != states.end()) std::erase(at->second, id);
    if (at != states.end() && at->second.empty()) states.erase(at);
  }
  info = {};
}

SlidingWindowSmoother::Impl::Values SlidingWindowSmoother::Impl::Snapshot() const {
  Values values;
  for (const Info& info : infos) {
    if (!graph.Contains(info.id)) continue;
    const double* block = graph.Block(info.id);
    values.emplace_back(info.id, std::vector<double>(block, block + SizeOf(info.id)));
  }
  return values;
}

void SlidingWindowSmoother::Impl::RollBack(const Values& values) {
  for (const FactorId& factor : new_factors) {
    if (graph.Contains(factor)) graph.RemoveFactor(factor);
  }
  for (const VariableId& variable : new_variables) {
    if (graph.Contains(variable)) Remove(variable);
  }
  for (const auto& [id, value] : values) {
    if (graph.Contains(id)) std::copy(value.begin(), value.end(), graph.MutableBlock(id));
  }
}

std::string SlidingWindowSmoother::Impl::FaultOfNewFactors() const {
  for (std::size_t i = 0; i < new_factors.size(); ++i) {
    if (!graph.Contains(new_factors[i])) continue;
    const std::string fault = graph.FaultOf(new_factors[i]);
    if (!fault.empty()) {
      return "factor " + std::to_string(i + 1) + " of the " + std::to_string(new_factors.size()) +
             " added since the last update: " + fault;
    }
  }
  return "";
}

std::string SlidingWindowSmoother::Impl::Solve(const Stopwatch& update,
                                               std::span<const VariableId> covariance_of,
                                               UpdateReport* report) {
  SolveOptions solve = options.solve;
  const double left = 1e-3 * options.budget_ms - update.Seconds() - shrink_seconds -
                      iteration_seconds - (covariance_of.empty() ? 0.0 : covariance_seconds);
  solve.max_seconds = std::min(solve.max_seconds, std::max(left, 1e-4));
  // States that leave afterwards do not affect the covariance, first-estimate Jacobians do.
  const bool by_solver = !options.marginalization.first_estimate_jacobians;
  if (!by_solver) covariance_of = {};
  const Stopwatch solving;
  report->solve = graph.SolveWithCovariance(solve, covariance_of, &report->covariance);
  covariance_seconds = solving.Seconds() - report->solve.seconds;
  report->message = report->solve.message;
  iteration_seconds = report->solve.seconds / (1.0 + report->solve.iterations);
  return report->solve.IsUsable() ? "" : "the solver failed: " + report->solve.message;
}

std::string SlidingWindowSmoother::Impl::FaultOfSolution() const {
  for (const Info& info : infos) {
    if (graph.Contains(info.id) && !IsFinite(graph.Block(info.id), SizeOf(info.id))) {
      return "the solution is not finite";
    }
  }
  if (!std::isfinite(options.max_error)) return "";
  for (std::size_t i = 0; i < new_factors.size(); ++i) {
    if (!graph.Contains(new_factors[i])) continue;
    const std::optional<double> squared = graph.TrySquaredError(new_factors[i]);
    if (!squared) return graph.FaultOf(new_factors[i]);
    const double error = std::sqrt(*squared / graph.Factor(new_factors[i]).num_residuals());
    if (!(error <= options.max_error)) {
      return "factor " + std::to_string(i + 1) + " of the " + std::to_string(new_factors.size()) +
             " added since the last update is left with an error of " + FixedText(error) +
             " a row, beyond max_error = " + FixedText(options.max_error);
    }
  }
  return "";
}

MarginalizationOptions SlidingWindowSmoother::Impl::PriorOptions() const {
  MarginalizationOptions result = options.marginalization;
  for (const Info& info : infos) {
    if (info.kind == Kind::kCalibration && graph.Contains(info.id)) {
      result.relinearized.push_back(graph.Block(info.id));
    }
  }
  return result;
}

// Returns the stamp that leaves next; empty if none does, or if the choice fails: see `fault`.
std::optional<Stamp> SlidingWindowSmoother::Impl::ChooseLeaving(UpdateReport* report,
                                                                std::string* fault) {
  if (states.empty()) return std::nullopt;
  const Stamp oldest = states.begin()->first, newest = states.rbegin()->first;
  if (ToSeconds(newest - oldest) > options.max_seconds) return oldest;
  if (states.size() <= static_cast<std::size_t>(options.max_states)) return std::nullopt;
  if (options.leaving == LeavingPolicy::kLeastInformation) return LeastInformative(report, fault);
  return oldest;
}

std::optional<Stamp> SlidingWindowSmoother::Impl::LeastInformative(UpdateReport* report,
                                                                   std::string* fault) {
  std::vector<Stamp> stamps;
  std::vector<std::vector<double*>> candidates;
  for (const auto& [stamp, ids] : states) {
    stamps.push_back(stamp);
    candidates.push_back(Blocks(ids));
  }
  const auto losses = internal::TryInformationLoss(graph.problem(), candidates,
                                                   {.marginalization = PriorOptions()}, fault);
  if (!losses) return std::nullopt;
  const std::vector<double>& loss = *losses;
  const std::size_t protect = static_cast<std::size_t>(options.protected_states);
  const std::size_t count = stamps.size() > protect ? stamps.size() - protect : 1;
  report->information_loss.clear();
  for (std::size_t i = 0; i < count; ++i) report->information_loss.emplace_back(stamps[i], loss[i]);
  const auto least =
      std::min_element(loss.begin(), loss.begin() + static_cast<std::ptrdiff_t>(count));
  return stamps[static_cast<std::size_t>(least - loss.begin())];
}

bool SlidingWindowSmoother::Impl::IsSeenFrom(const VariableId& landmark, Stamp stamp) const {
  for (const FactorId& factor : graph.FactorsOf(landmark)) {
    for (const VariableId& id : graph.VariablesOf(factor)) {
      if (InfoOf(id).kind == Kind::kState && InfoOf(id).stamp == stamp) return true;
    }
  }
  return false;
}

// Returns the landmarks that leave with the states of `stamp`. Suspends the observations of the
// others from `stamp`.
std::vector<VariableId> SlidingWindowSmoother::Impl::LeavingLandmarks(Stamp stamp, Leaving* all,
                                                                      UpdateReport* report) {
  const Stamp newest = states.rbegin()->first;
  std::map<std::uint32_t, std::vector<FactorId>> observations;  // landmark index -> factors
  for (const VariableId& state : states.at(stamp)) {
    for (const FactorId& factor : graph.FactorsOf(state)) {
      for (const VariableId& id : graph.VariablesOf(factor)) {
        if (InfoOf(id).kind == Kind::kLandmark) observations[id.index].push_back(factor);
      }
    }
  }
  std::vector<VariableId> leaving;
  std::vector<FactorId> dropped;
  for (const auto& [index, factors] : observations) {
    const VariableId landmark = infos[index].id;
    const bool stays = options.landmarks == LandmarkPolicy::kKeepTracked && stamp != newest &&
                       IsSeenFrom(landmark, newest);
    if (!stays) {
      leaving.push_back(landmark);
      continue;
    }
    dropped.insert(dropped.end(), factors.begin(), factors.end());
  }
  report->dropped_factors += static_cast<int>(Suspend(dropped, all));
  return leaving;
}

// Suspends factors, which may be listed repeatedly. Returns the number newly suspended.
std::size_t SlidingWindowSmoother::Impl::Suspend(const std::vector<FactorId>& factors,
                                                 Leaving* all) {
  const std::vector<FactorId> suspended = graph.Suspend(factors);
  all->factors.insert(all->factors.end(), suspended.begin(), suspended.end());
  return suspended.size();
}

void SlidingWindowSmoother::Impl::TakeBack(const Leaving& all) {
  for (const FactorId& factor : all.factors) {
    const bool prior = std::find(all.priors.begin(), all.priors.end(), factor) != all.priors.end();
    if (!prior) graph.Resume(factor);
  }
  for (const FactorId& prior : all.priors) graph.RemoveFactor(prior);
}

// Returns the reason why the states of `stamp` cannot be marginalized; empty if they were.
std::string SlidingWindowSmoother::Impl::Leave(Stamp stamp, Leaving* all, UpdateReport* report) {
  std::vector<VariableId> leaving = LeavingLandmarks(stamp, all, report);
  leaving.insert(leaving.end(), states.at(stamp).begin(), states.at(stamp).end());
  std::string fault;
  std::optional<Marginal> marginal =
      internal::TryMarginalize(graph.problem(), Blocks(leaving), PriorOptions(), &fault);
  if (!marginal) return fault;
  std::vector<FactorId> factors;
  for (const VariableId& id : leaving) {
    factors.insert(factors.end(), graph.FactorsOf(id).begin(), graph.FactorsOf(id).end());
  }
  Suspend(factors, all);
  states.erase(stamp);
  all->variables.insert(all->variables.end(), leaving.begin(), leaving.end());
  report->left.push_back(stamp);
  report->reports.push_back(marginal->report);
  if (marginal->prior == nullptr) return "";
  std::vector<VariableId> kept;
  for (const double* block : marginal->blocks) kept.push_back(graph.FindVariable(block));
  all->priors.push_back(graph.AddFactorToBlocks(std::move(marginal->prior), nullptr, kept));
  return "";
}

// Returns the reason why the states that should leave cannot; empty if they left.
std::string SlidingWindowSmoother::Impl::Shrink(UpdateReport* report) {
  const auto states_before = states;
  const UpdateReport before = *report;
  Leaving all;
  const auto take_back = [&] {
    TakeBack(all);
    states = states_before;
    *report = before;
  };
  std::string fault;
  try {
    while (const std::optional<Stamp> stamp = ChooseLeaving(report, &fault)) {
      fault = Leave(*stamp, &all, report);
      if (!fault.empty()) break;
    }
  } catch (...) {  // misuse or no memory: the window must not remain half changed
    take_back();
    throw;
  }
  if (!fault.empty()) {
    take_back();
    return fault;
  }
  for (const FactorId& factor : all.factors) graph.RemoveFactor(factor);
  report->removed = std::move(all.variables);
  const std::vector<VariableId> orphans = Select([&](const Info& info) {
    return info.kind == Kind::kLandmark && graph.FactorsOf(info.id).empty();
  });
  for (const VariableId& id : report->removed) Remove(id);
  for (const VariableId& id : orphans) {
    if (!graph.Contains(id)) continue;  // it is leaving
    Remove(id);
    report->removed.push_back(id);
  }
  return "";
}

SlidingWindowSmoother::SlidingWindowSmoother(const SlidingWindowOptions& options)
    : impl_(std::make_unique<Impl>()) {
  options.Validate();
  impl_->options = options;
}
SlidingWindowSmoother::~SlidingWindowSmoother() = default;
SlidingWindowSmoother::SlidingWindowSmoother(SlidingWindowSmoother&&) noexcept = default;
SlidingWindowSmoother& SlidingWindowSmoother::operator=(SlidingWindowSmoother&&) noexcept = default;

void SlidingWindowSmoother::RegisterVariable(const VariableId& variable, Kind kind, Stamp stamp,
                                             const char* type) {
  if (impl_->infos.size() <= variable.index) impl_->infos.resize(variable.index + 1);
  impl_->infos[variable.index] = {variable, kind, stamp, type};
  if (kind == Kind::kState) impl_->states[stamp].push_back(variable);
  impl_->new_variables.push_back(variable);
}

FactorId SlidingWindowSmoother::Register(const FactorId& factor) {
  impl_->new_factors.push_back(factor);
  return factor;
}

void SlidingWindowSmoother::RemoveFactor(const FactorId& factor) {
  impl_->graph.RemoveFactor(factor);
}

void SlidingWindowSmoother::Remove(const VariableId& variable) {
  HIGHWALL_REQUIRE(Contains(variable), "SlidingWindowSmoother: the variable is not in the window");
  impl_->Remove(variable);
}

void SlidingWindowSmoother::Fix(const VariableId& variable) {
  impl_->graph.Fix(variable);
}

UpdateReport SlidingWindowSmoother::Update(std::span<const VariableId> covariance_of) {
  const Stopwatch update;
  impl_->RequireDistinct(covariance_of);
  UpdateReport report;
  const Impl::Values before = impl_->Snapshot();
  std::string fault;
  const auto forget_new = [&] {
    impl_->new_variables.clear();
    impl_->new_factors.clear();
  };
  try {
    fault = impl_->FaultOfNewFactors();
    if (fault.empty()) fault = impl_->Solve(update, covariance_of, &report);
    if (fault.empty()) fault = impl_->FaultOfSolution();
    if (fault.empty() && !covariance_of.empty() && !report.covariance) {
      const Stopwatch summarizing;
      report.covariance = Covariance(covariance_of);
      impl_->covariance_seconds += summarizing.Seconds();
    }
    if (fault.empty()) {
      const Stopwatch shrinking;
      fault = impl_->Shrink(&report);
      impl_->shrink_seconds = shrinking.Seconds();
    }
  } catch (...) {  // misuse or no memory: the window must not remain half changed
    impl_->RollBack(before);
    forget_new();
    throw;
  }
  report.accepted = fault.empty();
  if (!report.accepted) {
    report.message = fault;
    report.covariance.reset();
    impl_->RollBack(before);
  }
  forget_new();
  report.seconds = update.Seconds();
  return report;
}

std::vector<Stamp> SlidingWindowSmoother::Stamps() const {
  std::vector<Stamp> stamps;
  for (const auto& [stamp, ids] : impl_->states) stamps.push_back(stamp);
  return stamps;
}

std::vector<VariableId> SlidingWindowSmoother::StatesAt(Stamp stamp) const {
  const auto found = impl_->states.find(stamp);
  return found == impl_->states.end() ? std::vector<VariableId>() : found->second;
}

std::optional<VariableId> SlidingWindowSmoother::FindState(Stamp stamp, const char* type) const {
  for (const VariableId& id : StatesAt(stamp)) {
    if (std::string_view(impl_->InfoOf(id).type) == type) return id;
  }
  return std::nullopt;
}

std::optional<Eigen::MatrixXd> SlidingWindowSmoother::Covariance(
    std::span<const VariableId> variables) const {
  impl_->RequireDistinct(variables);
  FactorGraph& graph = impl_->graph;
  // Uses the normal equations of the solver; if these leave any variable unobservable, falls back
  // to marginalization. With first-estimate Jacobians the equations differ.
  if (!impl_->options.marginalization.first_estimate_jacobians) {
    if (auto reduced = graph.ReducedCovariance(variables)) return reduced;
  }
  std::vector<double*> wanted;
  for (const VariableId& id : variables) wanted.push_back(graph.MutableBlock(id));
  return internal::MarginalCovariance(graph.problem(), wanted, impl_->PriorOptions());
}

std::optional<Eigen::MatrixXd> SlidingWindowSmoother::NewestCovariance() const {
  if (impl_->states.empty()) return std::nullopt;
  return Covariance(impl_->states.rbegin()->second);
}

void SlidingWindowSmoother::Save(const std::filesystem::path& path) const {
  const std::vector<VariableId> ids =
      impl_->Select([](const Impl::Info& info) { return info.kind != Kind::kLandmark; });
  internal::SlidingWindowFile file;
  std::vector<double*> unknown;
  std::map<const double*, int> place;
  for (const VariableId& id : ids) {
    const Impl::Info& info = impl_->InfoOf(id);
    double* block = impl_->graph.MutableBlock(id);
    place.emplace(block, static_cast<int>(file.variables.size()));
    const bool fixed = impl_->graph.IsFixed(id);
    if (!fixed) unknown.push_back(block);
    file.variables.push_back({info.kind == Kind::kCalibration, info.stamp, fixed, info.type,
                              std::vector<double>(block, block + impl_->SizeOf(id))});
  }
  const Marginal marginal = Summarize(impl_->graph.problem(), unknown, impl_->PriorOptions());
  if (marginal.prior != nullptr) {
    for (std::size_t i = 0; i < marginal.blocks.size(); ++i) {
      file.blocks.push_back(
          {place[marginal.blocks[i]], marginal.prior->blocks()[i].linearization_point});
    }
    file.A = marginal.prior->A();
    file.b = marginal.prior->b();
  }
  internal::WriteSlidingWindow(path, file);
}

namespace {

// Returns true if a step from x and the step back cancel, which they do not if a quaternion or a
// direction is not of unit length. manifold: null for a vector.
bool IsOnManifold(const ceres::Manifold* manifold, const std::vector<double>& x) {
  if (manifold == nullptr) return true;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const int ambient = manifold->AmbientSize(), tangent = manifold->TangentSize();
  if (x.size() != static_cast<std::size_t>(ambient)) return false;
  RowMajor plus(ambient, tangent), minus(tangent, ambient);
  return manifold->PlusJacobian(x.data(), plus.data()) &&
         manifold->MinusJacobian(x.data(), minus.data()) &&
         (minus * plus - RowMajor::Identity(tangent, tangent)).cwiseAbs().maxCoeff() <= 1e-6;
}

}  // namespace

void SlidingWindowSmoother::Restore(const std::filesystem::path& path,
                                    std::span<const VariableFactory> factories) {
  const internal::SlidingWindowFile file = internal::ReadSlidingWindow(path);
  std::vector<VariableId> ids;
  for (const internal::SavedVariable& saved : file.variables) {
    const auto factory =
        std::find_if(factories.begin(), factories.end(),
                     [&](const VariableFactory& f) { return saved.type == f.type; });
    if (factory == factories.end()) {
      throw IoError(path, "holds a variable of type " + saved.type + ": name its type to Load");
    }
    if (saved.values.size() != static_cast<std::size_t>(factory->size)) {
      throw IoError(path, "a variable of type " + saved.type + " has the wrong size");
    }
    const VariableId id = factory->add(impl_->graph, saved.values.data());
    const double* const added = impl_->graph.Block(id);
    if (!IsOnManifold(impl_->graph.problem().GetManifold(added), saved.values)) {
      throw IoError(path, "a variable of type " + saved.type + " is not of unit length");
    }
    // Copies the saved values, which the constructor of the type would normalise again.
    std::copy(saved.values.begin(), saved.values.end(), impl_->graph.MutableBlock(id));
    RegisterVariable(id, saved.calibration ? Kind::kCalibration : Kind::kState, saved.stamp,
                     factory->type);
    if (saved.fixed) impl_->graph.Fix(id);
    ids.push_back(id);
  }
  if (file.b.size() > 0) {
    std::vector<MarginalPrior::Block> blocks;
    std::vector<VariableId> under;
    for (const internal::SavedBlock& block : file.blocks) {
      const VariableId id = ids[static_cast<std::size_t>(block.variable)];
      const ceres::Manifold* manifold = impl_->graph.problem().GetManifold(impl_->graph.Block(id));
      if (!IsOnManifold(manifold, block.point)) {
        throw IoError(path, "a point of its prior is not of unit length");
      }
      under.push_back(id);
      blocks.push_back({block.point, manifold});
    }
    try {
      auto prior = std::make_unique<MarginalPrior>(std::move(blocks), file.A, file.b);
      impl_->graph.AddFactorToBlocks(std::move(prior), nullptr, under);
    } catch (const InvalidArgument& error) {  // the file's fault, which IoError reports
      throw IoError(path, std::string("its prior does not fit its variables: ") + error.what());
    }
  }
  impl_->new_variables.clear();
}

const FactorGraph& SlidingWindowSmoother::graph() const {
  return impl_->graph;
}

FactorGraph& SlidingWindowSmoother::mutable_graph() {
  return impl_->graph;
}

const SlidingWindowOptions& SlidingWindowSmoother::options() const {
  return impl_->options;
}

}  // namespace highwall
