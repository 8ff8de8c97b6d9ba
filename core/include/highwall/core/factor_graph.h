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

// Names a factor of one FactorGraph.
struct FactorId {
  std::uint32_t index = 0;
  std::uint32_t generation = 0;  // 0: no factor
  std::uint32_t graph = 0;       // a number of its own

  bool operator==(const FactorId&) const = default;
};

// A pointer that gives a factor away or shares it: std::unique_ptr or std::shared_ptr to a class
// derived from ceres::CostFunction.
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
// in the graph, or is one of another graph. A factor that throws, or is not finite, is one that
// cannot be evaluated. Nothing is printed. Not thread-safe: one thread at a time.
class FactorGraph {
 public:
  FactorGraph();
  ~FactorGraph();
  FactorGraph(FactorGraph&&) noexcept;
  FactorGraph& operator=(FactorGraph&&) noexcept;

  // Throws InvalidArgument if the value is not finite, or T's manifold one of another size.
  template <class T>
  Variable<T> AddVariable(const T& value) {
    return AddTyped(value, /*landmark=*/false);
  }
  // A variable that is eliminated first (Schur complement), such as a point or a line. No factor
  // may join two landmarks: Solve() then fails and says so.
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

  // Takes the variable out, and with it every factor that touches it.
  void Remove(const VariableId& variable);

  // A fixed variable keeps its value in Solve() and counts as known in Covariance().
  void Fix(const VariableId& variable);
  void Unfix(const VariableId& variable);
  bool IsFixed(const VariableId& variable) const;

  // loss: applied to |r|^2 (Huber and the like); may be null; share one among many factors.
  // Throws InvalidArgument if the factor is null, or if the number, the sizes or the identity
  // (twice the same) of the blocks do not fit it. Does not compile if the factor declares other
  // Variables.
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
  // In the order in which they were added. Both references: until a factor is added or removed.
  const std::vector<FactorId>& FactorsOf(const VariableId& variable) const;
  const std::vector<VariableId>& VariablesOf(const FactorId& factor) const;
  const ceres::CostFunction& Factor(const FactorId& factor) const;
  // Why it cannot be evaluated at the present values, naming its type and its variables; empty if
  // it can.
  std::string FaultOf(const FactorId& factor) const;

  // |r|^2 of one factor at the present values, without its loss: chi-squared where r is whitened.
  // Throws InvalidArgument, with FaultOf, if the factor cannot be evaluated there.
  double SquaredError(const FactorId& factor) const;
  // Sum over factors of rho(|r|^2) / 2. Throws as above.
  double Cost() const;

  // Improves the values of the variables that are not fixed. Throws only on bad options; see
  // SolveSummary::status for everything else: where it failed by a factor, the message names it.
  SolveSummary Solve(const SolveOptions& options = {});

  // Joint covariance of the variables in their tangent spaces, in the order given, from the
  // linearized graph: (J^T J)^-1 with losses applied. A fixed variable is known: zero rows and
  // columns. Empty if the factors do not determine these variables (an open gauge: fix a variable
  // or add a prior); whether they determine others does not matter. Throws InvalidArgument if a
  // factor cannot be evaluated.
  std::optional<Eigen::MatrixXd> Covariance(std::span<const VariableId> variables) const;
  std::optional<Eigen::MatrixXd> Covariance(const VariableId& variable) const {
    return Covariance(std::span<const VariableId>(&variable, 1));
  }
  // A variable that the factors do not determine, with one of them, and what to do; empty where
  // they determine all. Throws InvalidArgument if a factor cannot be evaluated.
  std::string Undetermined() const;

  // The block behind a handle, and the handle of a block (throws InvalidArgument if it is none).
  const double* Block(const VariableId& variable) const;
  double* MutableBlock(const VariableId& variable);
  VariableId FindVariable(const double* block) const;

  // The problem itself, to evaluate, linearize or solve it by other means. Add and remove through
  // the graph only. Its cost functions stand for the factors: see FindVariable and Factor.
  ceres::Problem& problem();
  const ceres::Problem& problem() const;

 private:
  friend class SlidingWindowSmoother;  // takes factors out on trial
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

  // The factors count as removed until Resume() gives each back under the same handle.
  // RemoveFactor() ends that too; their variables must not be removed before. Returns those that
  // were not suspended yet, in the order given.
  std::vector<FactorId> Suspend(std::span<const FactorId> factors);
  void Resume(const FactorId& factor);

  // Covariance(), the landmarks eliminated one by one; empty where there are none, where two are
  // joined or one is asked for, or where the factors leave a variable open.
  std::optional<Eigen::MatrixXd> ReducedCovariance(std::span<const VariableId> variables) const;
  // Solve(), and ReducedCovariance() of where it ended by the equations that it ended with. Empty
  // also where it failed, or did not solve by variable projection.
  SolveSummary SolveWithCovariance(const SolveOptions& options,
                                   std::span<const VariableId> variables,
                                   std::optional<Eigen::MatrixXd>* covariance);

  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
