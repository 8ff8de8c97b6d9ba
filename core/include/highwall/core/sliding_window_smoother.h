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

// Selects the states that leave a full window.
enum class LeavingPolicy {
  kOldestFirst,
  // The state whose factors give the least information about the remaining states
  // (InformationLoss()). Costs two eliminations of the window per candidate.
  kLeastInformation,
};
const char* ToString(LeavingPolicy policy);

// Treatment of a landmark that is observed by a leaving state and by other states. Landmarks are
// never in the prior: they stay independent of each other.
enum class LandmarkPolicy {
  // It stays, without the observations of the leaving state, if the newest state observes it;
  // otherwise it leaves, and all its observations go into the prior.
  kKeepTracked,
  // It leaves, and all its observations go into the prior. No observation is lost; a landmark that
  // is observed again is a new landmark.
  kMarginalize,
};
const char* ToString(LandmarkPolicy policy);

// Options of SlidingWindowSmoother.
struct SlidingWindowOptions {
  int max_states = 10;  // >= 1; distinct stamps that stay in the window
  // [s] > 0; a state leaves if it is older than the newest one by more than this
  double max_seconds = std::numeric_limits<double>::infinity();
  // [ms] > 0 for a whole Update(); the solver stops early enough for the steps after it
  double budget_ms = std::numeric_limits<double>::infinity();
  LeavingPolicy leaving = LeavingPolicy::kOldestFirst;
  int protected_states = 2;  // >= 1; newest stamps that kLeastInformation never chooses
  LandmarkPolicy landmarks = LandmarkPolicy::kKeepTracked;
  // > 0; an update is rejected if a new factor has |r| / sqrt(rows) above this after the solve. In
  // sigma where r is whitened.
  double max_error = std::numeric_limits<double>::infinity();
  // Calibration variables are relinearized in any case.
  MarginalizationOptions marginalization{};
  SolveOptions solve{.max_iterations = 10,
                     .function_tolerance = 1e-3,
                     .linear_solver = LinearSolver::kVariableProjection};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Report of SlidingWindowSmoother::Update().
struct UpdateReport {
  bool accepted = false;
  std::string message;  // reason of the rejection; the message of the solver if accepted
  SolveSummary solve;
  std::vector<Stamp> left;                     // states that left, oldest first
  std::vector<VariableId> removed;             // variables that were removed, landmarks included
  std::vector<MarginalizationReport> reports;  // one for each stamp of `left`
  std::vector<std::pair<Stamp, double>> information_loss;  // [nats] of the last candidates compared
  // Covariance of the variables given to Update(): as SlidingWindowSmoother::Covariance(), before
  // any state leaves.
  std::optional<Eigen::MatrixXd> covariance;
  int dropped_factors = 0;  // observations of remaining landmarks by states that left
  double seconds = 0.0;     // wall time of the whole update
};

// A fixed-lag smoother over a FactorGraph: the newest states stay in the window, older states are
// marginalized into a prior (marginalization.h). Accepts any factor and any variable.
//
//   SlidingWindowSmoother smoother({.max_states = 10});
//   const Variable<Pose> pose = smoother.AddState(stamp, T_WB);
//   const Variable<Point> point = smoother.AddLandmark(p_W);
//   smoother.AddFactor(std::make_unique<PointReprojection>(...), loss, pose, point);
//   const UpdateReport report = smoother.Update();
//   const Pose T_WB = smoother.Value(pose);
//
// The additions since the last Update() are accepted or rejected as a whole. Functions that take a
// handle throw InvalidArgument if it is no longer in the window. Not thread-safe.
class SlidingWindowSmoother {
 public:
  explicit SlidingWindowSmoother(const SlidingWindowOptions& options = {});
  ~SlidingWindowSmoother();
  SlidingWindowSmoother(SlidingWindowSmoother&&) noexcept;
  SlidingWindowSmoother& operator=(SlidingWindowSmoother&&) noexcept;

  // Adds a variable that leaves with its stamp: a pose, a velocity, a bias. Several may share a
  // stamp; stamps may come in any order. Throws InvalidArgument if the value is not finite.
  template <class T>
  Variable<T> AddState(Stamp stamp, const T& value) {
    return Register(mutable_graph().AddVariable(value), Kind::kState, stamp, typeid(T).name());
  }
  // Adds a variable that leaves once no state of the window observes it. No factor may connect two.
  template <class T>
  Variable<T> AddLandmark(const T& value) {
    return Register(mutable_graph().AddLandmark(value), Kind::kLandmark, 0, typeid(T).name());
  }
  // Adds a variable that never leaves: calibration. Never linearized at a first estimate.
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
  // Take effect immediately; a rejected update does not restore what was removed.
  void RemoveFactor(const FactorId& factor);
  void Remove(const VariableId& variable);
  // Makes a variable constant: it is not estimated, and no prior is formed on it.
  void Fix(const VariableId& variable);

  // Solves from the current values, then marginalizes the states and landmarks that leave. Rejects
  // all additions since the last call (their handles become stale) and restores the values if a new
  // factor cannot be evaluated, throws or is not finite, if the solver or a marginalization fails,
  // or if the error of a new factor stays above max_error; no state has left then.
  //   covariance_of: variables whose joint covariance is added to the report, at less cost than a
  // later Covariance(), because it reuses the last linear system of the solver.
  // Throws InvalidArgument, before any change, if one of these is given twice or is no longer in
  // the window. Any other exception is one of the system, such as std::bad_alloc: the additions are
  // then discarded as well.
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

  // Returns the stamps of the states in the window, ascending.
  std::vector<Stamp> Stamps() const;
  // Returns the states at a stamp, in the order of insertion.
  std::vector<VariableId> StatesAt(Stamp stamp) const;
  // Returns the first state of type T at a stamp.
  template <class T>
  std::optional<Variable<T>> Find(Stamp stamp) const {
    const std::optional<VariableId> id = FindState(stamp, typeid(T).name());
    if (!id) return std::nullopt;
    return Variable<T>{*id};
  }

  // Returns the joint covariance of the variables in their tangent spaces, in the order given; a
  // fixed variable has zero rows and columns. Empty if these variables are not observable from the
  // factors, or if a factor cannot be evaluated; other variables may be unobservable. Throws
  // InvalidArgument if one is given twice.
  std::optional<Eigen::MatrixXd> Covariance(std::span<const VariableId> variables) const;
  // Covariance of the states at the newest stamp, in the order of StatesAt. Empty if there are
  // none.
  std::optional<Eigen::MatrixXd> NewestCovariance() const;

  // Writes states and calibration with one prior that replaces all factors, linearized at the
  // current values; landmarks are marginalized. Throws IoError; the file is written atomically.
  // docs/sliding_window_smoother.md describes the format (version 1).
  void Save(const std::filesystem::path& path) const;
  // Loads a saved smoother. Ts: the types of the saved variables. Throws IoError if the file is
  // missing, malformed, of another version, or contains a variable of a type that is not among Ts.
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
  // Adds a variable whose type is known by its name only.
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
