#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/factor_graph.h>
#include <highwall/core/marginalization.h>
#include <highwall/core/solver.h>
#include <highwall/core/stamp.h>

namespace [[gnu::visibility("default")]] highwall {

// Which states leave when there are more than fit.
enum class LeavingPolicy {
  kOldestFirst,
  // The one whose factors tell least about the states that stay (InformationLoss()). Costs two
  // eliminations of the window per candidate.
  kLeastInformation,
};
const char* ToString(LeavingPolicy policy);

// What becomes of a landmark that a leaving state observes and that other states observe too.
// Landmarks are never in the prior: they stay independent of each other.
enum class LandmarkPolicy {
  // It stays, without the observations of the leaving state, if the newest state observes it; else
  // it leaves, and all its observations go into the prior.
  kKeepTracked,
  // It leaves, and all its observations go into the prior. No observation is lost; a landmark that
  // is observed again is a new one.
  kMarginalize,
};
const char* ToString(LandmarkPolicy policy);

// Of SlidingWindowSmoother.
struct SlidingWindowOptions {
  int max_states = 10;  // >= 1; distinct stamps that stay in the window
  // [s] > 0; a state that is older than this before the newest one leaves
  double max_seconds = std::numeric_limits<double>::infinity();
  // [ms] > 0 for a whole Update(); the solver stops in time for what comes after it
  double budget_ms = std::numeric_limits<double>::infinity();
  LeavingPolicy leaving = LeavingPolicy::kOldestFirst;
  int protected_states = 2;  // >= 1; newest stamps that kLeastInformation never chooses
  LandmarkPolicy landmarks = LandmarkPolicy::kKeepTracked;
  // > 0; an update is rejected if a new factor is left with |r| / sqrt(rows) beyond this. In sigma
  // where r is whitened.
  double max_error = std::numeric_limits<double>::infinity();
  // Calibration variables are relinearized in any case.
  MarginalizationOptions marginalization{};
  SolveOptions solve{.max_iterations = 10,
                     .function_tolerance = 1e-3,
                     .linear_solver = LinearSolver::kVariableProjection};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// What became of SlidingWindowSmoother::Update().
struct UpdateReport {
  bool accepted = false;
  std::string message;  // why it was rejected; the solver's words if accepted
  SolveSummary solve;
  std::vector<Stamp> left;                     // states that left, oldest first
  std::vector<VariableId> removed;             // variables that are gone, landmarks included
  std::vector<MarginalizationReport> reports;  // one for each stamp of `left`
  std::vector<std::pair<Stamp, double>> information_loss;  // [nats] of the candidates last compared
  // Of the variables that Update() was asked for: as SlidingWindowSmoother::Covariance(), before
  // any state leaves.
  std::optional<Eigen::MatrixXd> covariance;
  int dropped_factors = 0;  // observations of landmarks that stay, by states that left
  double seconds = 0.0;     // wall time of the whole update
};

// A fixed-lag smoother over a FactorGraph: the newest states stay in the window, those before leave
// behind a prior (marginalization.h). Any factor, any variable.
//
//   SlidingWindowSmoother smoother({.max_states = 10});
//   const Variable<Pose> pose = smoother.AddState(stamp, T_WB);
//   const Variable<Point> point = smoother.AddLandmark(p_W);
//   smoother.AddFactor(std::make_unique<PointReprojection>(...), loss, pose, point);
//   const UpdateReport report = smoother.Update();
//   const Pose T_WB = smoother.Value(pose);
//
// What is added since the last Update() is taken or rejected as a whole. Functions that take a
// handle throw InvalidArgument if it is no longer in the window. Not thread-safe.
class SlidingWindowSmoother {
 public:
  explicit SlidingWindowSmoother(const SlidingWindowOptions& options = {});
  ~SlidingWindowSmoother();
  SlidingWindowSmoother(SlidingWindowSmoother&&) noexcept;
  SlidingWindowSmoother& operator=(SlidingWindowSmoother&&) noexcept;

  // A variable that leaves with its stamp: a pose, a velocity, a bias. Several may share a stamp;
  // stamps may come in any order. Throws InvalidArgument if the value is not finite.
  template <class T>
  Variable<T> AddState(Stamp stamp, const T& value) {
    return Register(mutable_graph().AddVariable(value), Kind::kState, stamp, typeid(T).name());
  }
  // A variable that leaves once no state of the window observes it. No factor may join two.
  template <class T>
  Variable<T> AddLandmark(const T& value) {
    return Register(mutable_graph().AddLandmark(value), Kind::kLandmark, 0, typeid(T).name());
  }
  // A variable that stays: calibration. Never linearized at a first estimate.
  template <class T>
  Variable<T> AddCalibration(const T& value) {
    return Register(mutable_graph().AddVariable(value), Kind::kCalibration, 0, typeid(T).name());
  }

  // As FactorGraph::AddFactor.
  template <FactorPointer P, class... Ts>
  requires AcceptsVariables<typename P::element_type, Ts...> FactorId
  AddFactor(P factor, std::shared_ptr<ceres::LossFunction> loss, const Variable<Ts>&... variables) {
    return Register(mutable_graph().AddFactor(std::move(factor), std::move(loss), variables...));
  }
  template <FactorPointer P, class... Ts>
  requires AcceptsVariables<typename P::element_type, Ts...> FactorId
  AddFactor(P factor, const Variable<Ts>&... variables) {
    return AddFactor(std::move(factor), std::shared_ptr<ceres::LossFunction>(), variables...);
  }
  FactorId AddFactorToBlocks(std::shared_ptr<ceres::CostFunction> factor,
                             std::shared_ptr<ceres::LossFunction> loss,
                             std::span<const VariableId> variables) {
    return Register(
        mutable_graph().AddFactorToBlocks(std::move(factor), std::move(loss), variables));
  }
  // Take effect at once; a rejected update does not bring back what was removed.
  void RemoveFactor(const FactorId& factor);
  void Remove(const VariableId& variable);
  // A fixed variable is known: it does not move, and no prior is formed on it.
  void Fix(const VariableId& variable);

  // Solves from the present values, then marginalizes what no longer fits. Rejects everything that
  // was added since the last call (those handles are stale then), and keeps the values as they
  // were, if a new factor cannot be evaluated, throws or is not finite, if the solver or a
  // marginalization fails, or if a new factor is left beyond max_error; then nothing has left.
  //   covariance_of: variables whose joint covariance is to be in the report, for less than
  // Covariance() costs afterwards: the solver's last equations are at hand.
  // Throws InvalidArgument, before anything is done, if one of these is given twice or is no longer
  // in the window; nothing else.
  UpdateReport Update(std::span<const VariableId> covariance_of = {});

  template <class T>
  T Value(const Variable<T>& variable) const {
    return graph().Value(variable);
  }
  template <class T>
  void SetValue(const Variable<T>& variable, const T& value) {
    mutable_graph().SetValue(variable, value);
  }
  bool Contains(const VariableId& variable) const { return graph().Contains(variable); }
  bool Contains(const FactorId& factor) const { return graph().Contains(factor); }

  // Of the states in the window, ascending.
  std::vector<Stamp> Stamps() const;
  // States at a stamp, in the order in which they were added.
  std::vector<VariableId> StatesAt(Stamp stamp) const;
  // The first state of type T at a stamp.
  template <class T>
  std::optional<Variable<T>> Find(Stamp stamp) const {
    const std::optional<VariableId> id = FindState(stamp, typeid(T).name());
    if (!id) return std::nullopt;
    return Variable<T>{*id};
  }

  // Joint covariance of the variables in their tangent spaces, in the order given; a fixed variable
  // has zero rows and columns. Empty if the factors do not determine these variables; whether they
  // determine others does not matter. Throws InvalidArgument if one is given twice, or if a factor
  // cannot be evaluated.
  std::optional<Eigen::MatrixXd> Covariance(std::span<const VariableId> variables) const;
  // Of the states at the newest stamp, in the order of StatesAt. Empty if there are none.
  std::optional<Eigen::MatrixXd> NewestCovariance() const;

  // Writes states and calibration with one prior that stands for all factors, linearized at the
  // present values; landmarks are marginalized. Throws IoError; the file appears whole or not at
  // all. docs/sliding_window_smoother.md describes the format (version 1).
  void Save(const std::filesystem::path& path) const;
  // The smoother as saved. Ts: the types of the saved variables. Throws IoError if the file is
  // missing, malformed, of another version, or holds a variable of a type that is not among Ts.
  template <class... Ts>
  static SlidingWindowSmoother Load(const std::filesystem::path& path,
                                    const SlidingWindowOptions& options = {}) {
    SlidingWindowSmoother smoother(options);
    const std::vector<VariableFactory> factories = {MakeFactory<Ts>()...};
    smoother.Restore(path, factories);
    return smoother;
  }

  const FactorGraph& graph() const;
  const SlidingWindowOptions& options() const;

 private:
  enum class Kind { kState, kLandmark, kCalibration };
  // Adds a variable of a type known by its name only.
  struct VariableFactory {
    const char* type;
    int size;
    VariableId (*add)(FactorGraph&, const double*);
  };
  struct Impl;

  template <class T>
  static VariableFactory MakeFactory() {
    return {typeid(T).name(), VariableTraits<T>::kSize,
            [](FactorGraph& graph, const double* block) -> VariableId {
              return graph.AddVariable(VariableTraits<T>::Read(block));
            }};
  }

  FactorGraph& mutable_graph();
  template <class T>
  Variable<T> Register(const Variable<T>& variable, Kind kind, Stamp stamp, const char* type) {
    RegisterVariable(variable, kind, stamp, type);
    return variable;
  }
  void RegisterVariable(const VariableId& variable, Kind kind, Stamp stamp, const char* type);
  FactorId Register(const FactorId& factor);
  std::optional<VariableId> FindState(Stamp stamp, const char* type) const;
  void Restore(const std::filesystem::path& path, std::span<const VariableFactory> factories);

  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
