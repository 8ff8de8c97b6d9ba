#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include <highwall/core/solver.h>
#include <highwall/core/variable.h>

namespace ceres {
class LossFunction;
class Problem;
}  // namespace ceres

namespace [[gnu::visibility("default")]] highwall {

// Handle of a factor of one FactorGraph.
struct FactorId {
  std::uint32_t index = 0;
  std::uint32_t generation = 0;  // 0: no factor
  std::uint32_t graph = 0;       // unique number of the graph

  bool operator==(const FactorId&) const = default;
};

// A pointer that transfers or shares the ownership of a factor: std::unique_ptr or std::shared_ptr
// to a class derived from ceres::CostFunction.
template <class P>
concept FactorPointer = std::convertible_to<P, std::shared_ptr<ceres::CostFunction>> && requires {
  typename P::element_type;
};

// Variables and factors over one ceres::Problem: minimizes the sum of rho(|r|^2) / 2 over factors.
//
//   FactorGraph graph;
//   const Variable<Pose> pose = graph.AddVariable(Pose());
//   const Variable<Point> point = graph.AddLandmark(Point(0, 0, 2));
//   graph.AddFactor(std::make_unique<PointReprojection>(...), loss, pose, point);
//   const SolveSummary summary = graph.Solve();
//   const Pose T_WB = graph.Value(pose);
//
// A factor is any ceres::CostFunction with true ambient Jacobians, analytic or AutoDiff. The graph
// owns the blocks, whose addresses never change, and keeps the factors and losses alive.
// Every function that takes a handle throws InvalidArgument if its variable or factor is no longer
// in the graph or belongs to another graph. A factor that throws or is not finite counts as one
// that cannot be evaluated. Nothing is printed. Not thread-safe: one thread at a time.
class FactorGraph {
 public:
  FactorGraph();
  ~FactorGraph();
  FactorGraph(FactorGraph&&) noexcept;
  FactorGraph& operator=(FactorGraph&&) noexcept;

  // Throws InvalidArgument if the value is not finite or the manifold of T has another size.
  template <class T>
  Variable<T> AddVariable(const T& value) {
    return AddTyped(value, /*landmark=*/false);
  }
  // Adds a variable that is eliminated first (Schur complement), such as a point or a line. No
  // factor may connect two landmarks: Solve() then fails with a message.
  template <class T>
  Variable<T> AddLandmark(const T& value) {
    return AddTyped(value, /*landmark=*/true);
  }

  template <class T>
  T Value(const Variable<T>& variable) const {
    return VariableTraits<T>::Read(Block(variable));
  }
  // Throws InvalidArgument if the value is not finite.
  template <class T>
  void SetValue(const Variable<T>& variable, const T& value) {
    std::array<double, VariableTraits<T>::kSize> block;
    VariableTraits<T>::Write(value, block.data());
    SetBlock(variable, block);
  }

  // Removes the variable and every factor that is connected to it.
  void Remove(const VariableId& variable);

  // A fixed variable keeps its value in Solve() and counts as known in Covariance().
  void Fix(const VariableId& variable);
  void Unfix(const VariableId& variable);
  bool IsFixed(const VariableId& variable) const;

  // loss: applied to |r|^2 (Huber and similar); may be null; may be shared by many factors. Throws
  // InvalidArgument if the factor is null or has no residuals, if the number or the sizes of the
  // blocks do not fit it, or if a block is given twice. Does not compile if the factor declares
  // other Variables.
  template <FactorPointer P, class... Ts>
  requires AcceptsVariables<typename P::element_type, Ts...> FactorId
  AddFactor(P factor, std::shared_ptr<ceres::LossFunction> loss, const Variable<Ts>&... variables) {
    const std::array<VariableId, sizeof...(Ts)> ids = {variables...};
    return AddFactorToBlocks(std::move(factor), std::move(loss), ids);
  }
  template <FactorPointer P, class... Ts>
  requires AcceptsVariables<typename P::element_type, Ts...> FactorId
  AddFactor(P factor, const Variable<Ts>&... variables) {
    return AddFactor(std::move(factor), std::shared_ptr<ceres::LossFunction>(), variables...);
  }
  // For factors whose blocks are known at run time only, such as a marginal prior.
  FactorId AddFactorToBlocks(std::shared_ptr<ceres::CostFunction> factor,
                             std::shared_ptr<ceres::LossFunction> loss,
                             std::span<const VariableId> variables);
  void RemoveFactor(const FactorId& factor);

  bool Contains(const VariableId& variable) const;
  bool Contains(const FactorId& factor) const;
  std::size_t NumVariables() const;
  std::size_t NumFactors() const;
  // In the order of insertion; valid until a factor is added or removed.
  const std::vector<FactorId>& FactorsOf(const VariableId& variable) const;
  std::vector<VariableId> VariablesOf(const FactorId& factor) const;
  const ceres::CostFunction& Factor(const FactorId& factor) const;
  // Returns the reason why the factor cannot be evaluated at the current values, with its type and
  // its variables; empty if it can be evaluated.
  std::string FaultOf(const FactorId& factor) const;

  // Returns |r|^2 of one factor at the current values, without its loss: chi-squared where r is
  // whitened. Throws InvalidArgument, with FaultOf, if the factor cannot be evaluated.
  double SquaredError(const FactorId& factor) const;
  // Returns the sum over factors of rho(|r|^2) / 2. Throws as above.
  double Cost() const;

  // Optimizes the variables that are not fixed. Throws only on invalid options; all other failures
  // are reported by SolveSummary::status, with the name of the factor where one caused the failure.
  SolveSummary Solve(const SolveOptions& options = {});

  // Returns the joint covariance of the variables in their tangent spaces, in the order given, from
  // the linearized graph: (J^T J)^-1 with losses applied. A fixed variable is known: zero rows and
  // columns. Empty if these variables are not observable from the factors (gauge freedom: fix a
  // variable or add a prior), or if a factor cannot be evaluated; Undetermined() gives the reason.
  // Other variables may be unobservable.
  std::optional<Eigen::MatrixXd> Covariance(std::span<const VariableId> variables) const;
  std::optional<Eigen::MatrixXd> Covariance(const VariableId& variable) const {
    return Covariance(std::span<const VariableId>(&variable, 1));
  }
  // Names a factor that cannot be evaluated (FaultOf), or else a variable that is not observable
  // from the factors, one of its factors, and a remedy; empty if there is neither.
  std::string Undetermined() const;

  // The block of a handle, and the handle of a block (throws InvalidArgument if there is none).
  const double* Block(const VariableId& variable) const;
  double* MutableBlock(const VariableId& variable);
  VariableId FindVariable(const double* block) const;

  // The underlying problem, to evaluate, linearize or solve it by other means. It holds what is in
  // the graph at the time of the call. Add, remove, fix and unfix through the graph only. Its cost
  // functions are wrappers of the factors: see FindVariable and Factor.
  ceres::Problem& problem();
  const ceres::Problem& problem() const;

 private:
  friend class SlidingWindowSmoother;  // suspends factors temporarily
  using MakeManifold = std::unique_ptr<ceres::Manifold> (*)();
  struct Impl;

  template <class T>
  Variable<T> AddTyped(const T& value, bool landmark) {
    std::array<double, VariableTraits<T>::kSize> block;
    VariableTraits<T>::Write(value, block.data());
    return {AddBlock(block, &VariableTraits<T>::MakeManifold, typeid(T), landmark)};
  }
  VariableId AddBlock(std::span<const double> values, MakeManifold make_manifold,
                      const std::type_info& type, bool landmark);
  void SetBlock(const VariableId& variable, std::span<const double> values);

  // Treats the factors as removed until Resume() restores each under the same handle.
  // RemoveFactor() also ends the suspension; their variables must not be removed before. Returns
  // the factors that were not suspended before, in the order given.
  std::vector<FactorId> Suspend(std::span<const FactorId> factors);
  void Resume(const FactorId& factor);

  // SquaredError(), empty if the factor cannot be evaluated.
  std::optional<double> TrySquaredError(const FactorId& factor) const;
  // Covariance() with the landmarks eliminated one by one. Also empty if there are no landmarks, if
  // a factor connects two of them, if one of them is requested, or if any variable is unobservable.
  std::optional<Eigen::MatrixXd> ReducedCovariance(std::span<const VariableId> variables) const;
  // Solve(), then ReducedCovariance() at the solution, with variable projection from the final
  // linear system of the solver. Also empty if the solver failed or leaves the landmarks to Ceres.
  SolveSummary SolveWithCovariance(const SolveOptions& options,
                                   std::span<const VariableId> variables,
                                   std::optional<Eigen::MatrixXd>* covariance);

  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
