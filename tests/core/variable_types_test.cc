// Calls that must not compile, and variables of types unknown to Highwall.

#include <highwall/core/variable.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <memory>
#include <type_traits>

#include <ceres/autodiff_cost_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/line3.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>
#include <highwall/core/sliding_window_smoother.h>

#include "support/can_add.h"

namespace highwall {

template <>
struct VariableTraits<Eigen::Quaterniond> {
  static constexpr int kSize = 4;
  static void Write(const Eigen::Quaterniond& q, double* block) {
    std::copy_n(q.coeffs().data(), kSize, block);
  }
  static Eigen::Quaterniond Read(const double* block) { return Eigen::Quaterniond(block); }
  static std::unique_ptr<ceres::Manifold> MakeManifold() {
    return std::make_unique<ceres::EigenQuaternionManifold>();
  }
};

}  // namespace highwall

namespace highwall::variable_types_test {
namespace {

template <class Graph>
constexpr bool kOnlyTheDeclaredVariablesCompile =
    CanAdd<Graph, std::unique_ptr<RelativePose>, Pose, Pose>&&
        CanAdd<Graph, std::shared_ptr<RelativePose>, Pose, Pose> &&
    !CanAdd<Graph, std::unique_ptr<RelativePose>, Pose, Point> &&
    !CanAdd<Graph, std::unique_ptr<RelativePose>, Pose> &&
    !CanAdd<Graph, std::unique_ptr<PosePrior>, Point> &&
    !CanAdd<Graph, std::unique_ptr<DirectionPrior>, Point> &&
    !CanAdd<Graph, std::unique_ptr<VectorPrior<3>>, UnitDirection> &&
    !CanAdd<Graph, std::unique_ptr<VectorPrior<6>>, Segment3> &&
    CanAdd<Graph, std::unique_ptr<VectorPrior<1>>, double> &&
    // A factor without declared types is checked when it is added.
    CanAdd<Graph, std::unique_ptr<ceres::CostFunction>, Pose, Point>;

TEST(VariableTypes, OnlyTheDeclaredVariablesCompile) {
  static_assert(kOnlyTheDeclaredVariablesCompile<FactorGraph>);
  static_assert(kOnlyTheDeclaredVariablesCompile<SlidingWindowSmoother>);
}

template <class Id>
concept NamesAVariable = requires(FactorGraph graph, Id id) {
  graph.Remove(id);
  graph.Fix(id);
  graph.FactorsOf(id);
  graph.Block(id);
  graph.Covariance(id);
};

template <class Id>
concept NamesAFactor = requires(FactorGraph graph, Id id) {
  graph.RemoveFactor(id);
  graph.Factor(id);
  graph.VariablesOf(id);
  graph.SquaredError(id);
};

template <class T, class Value>
concept CanSet = requires(FactorGraph graph, Variable<T> variable, Value value) {
  graph.SetValue(variable, value);
};

TEST(VariableTypes, HandlesOfOneKindDoNotCompileAsAnother) {
  static_assert(NamesAVariable<Variable<Pose>> && !NamesAFactor<Variable<Pose>>);
  static_assert(NamesAVariable<VariableId> && !NamesAFactor<VariableId>);
  static_assert(NamesAFactor<FactorId> && !NamesAVariable<FactorId>);
  static_assert(!std::equality_comparable_with<VariableId, FactorId>);
  static_assert(!std::is_convertible_v<Variable<Point>, Variable<Pose>>);
  static_assert(!std::is_assignable_v<Variable<Pose>&, Variable<Point>>);
  static_assert(!std::is_convertible_v<VariableId, Variable<Pose>>);
  static_assert(CanSet<Pose, Pose> && !CanSet<Pose, Point> && !CanSet<Point, UnitDirection>);
}

// An angle type unknown to Highwall: its block is (cos, sin).
class CircleManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 2; }
  int TangentSize() const override { return 1; }
  bool Plus(const double* x, const double* d, double* y) const override {
    const double c = std::cos(*d), s = std::sin(*d);
    const Eigen::Vector2d turned(c * x[0] - s * x[1], s * x[0] + c * x[1]);
    Eigen::Vector2d::Map(y) = turned;
    return true;
  }
  bool PlusJacobian(const double* x, double* J) const override {
    Eigen::Vector2d::Map(J) << -x[1], x[0];
    return true;
  }
  bool Minus(const double* y, const double* x, double* d) const override {
    *d = std::atan2(x[0] * y[1] - x[1] * y[0], x[0] * y[0] + x[1] * y[1]);
    return true;
  }
  bool MinusJacobian(const double* x, double* J) const override { return PlusJacobian(x, J); }
};

template <class M>
class AngleOn {
 public:
  static constexpr int kSize = 2;
  using Manifold = M;

  explicit AngleOn(double angle = 0.0) : data_{std::cos(angle), std::sin(angle)} {}
  double angle() const { return std::atan2(data_[1], data_[0]); }
  double* data() { return data_.data(); }
  const double* data() const { return data_.data(); }

 private:
  std::array<double, kSize> data_;
};
using Angle = AngleOn<CircleManifold>;

// Constrains two angles to differ by 1 rad.
struct OneRadian {
  template <class S>
  bool operator()(const S* x, const S* y, S* r) const {
    using std::atan2;
    r[0] = atan2(x[0] * y[1] - x[1] * y[0], x[0] * y[0] + x[1] * y[1]) - 1.0;
    return true;
  }
};

TEST(VariableTypes, AUsersTypeBringsItsOwnManifold) {
  FactorGraph graph;
  const Variable<Angle> x = graph.AddVariable(Angle(3.0)), y = graph.AddVariable(Angle(-2.5));
  EXPECT_EQ(graph.problem().ParameterBlockTangentSize(graph.Block(x)), 1);
  graph.Fix(x);
  graph.AddFactor(std::make_unique<ceres::AutoDiffCostFunction<OneRadian, 1, 2, 2>>(new OneRadian),
                  x, y);
  const SolveSummary summary = graph.Solve(
      {.function_tolerance = 0.0, .gradient_tolerance = 1e-15, .parameter_tolerance = 1e-15});
  EXPECT_EQ(summary.status, SolveStatus::kConverged) << summary.message;
  // The estimate crosses half a turn and stays on the circle. Both hold to rounding, because the
  // residual is linear in d.
  EXPECT_NEAR(graph.Value(y).angle(), 4.0 - 2.0 * M_PI, 1e-12);
  EXPECT_NEAR(std::hypot(graph.Block(y)[0], graph.Block(y)[1]), 1.0, 1e-14);
  EXPECT_NEAR((*graph.Covariance(y))(0, 0), 1.0, 1e-12);
}

TEST(VariableTypes, ATypeOfAnotherLibraryBecomesAVariableByItsTraits) {
  FactorGraph graph;
  const Eigen::Quaterniond q(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
  const Variable<Eigen::Quaterniond> id = graph.AddVariable(q);
  EXPECT_EQ(graph.Value(id).coeffs(), q.coeffs());
  EXPECT_EQ(graph.problem().ParameterBlockTangentSize(graph.Block(id)), 3);
}

TEST(VariableTypes, AManifoldOfAnotherSizeIsRefusedBeforeCeresSeesIt) {
  FactorGraph graph;
  for (int attempt = 0; attempt < 2; ++attempt) {
    EXPECT_THROW(graph.AddVariable(AngleOn<PoseManifold>()), InvalidArgument);
  }
  EXPECT_EQ(graph.NumVariables(), 0u);
  EXPECT_EQ(graph.Value(graph.AddVariable(Angle(0.5))).angle(), 0.5);
}

}  // namespace
}  // namespace highwall::variable_types_test
