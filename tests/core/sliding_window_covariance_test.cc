#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/prior.h>
#include <highwall/core/sliding_window_smoother.h>

#include "plane_steps.h"
#include "plane_walk.h"
#include "point_observation.h"
#include "random_states.h"

namespace highwall::sliding_window_covariance_test {
namespace {

TEST(SlidingWindowCovariance, CovarianceDoesNotMindOtherUnknownsAndCountsFixedOnesAsKnown) {
  SlidingWindowSmoother smoother;
  const auto a = smoother.AddState(0, Vector2(0, 0)), b = smoother.AddState(1, Vector2(0, 0));
  smoother.AddState(0, Vector2(0, 0));  // an unconstrained state
  smoother.AddFactor(MakePrior({0, 0}, 0.5), a);
  smoother.AddFactor(MakeStep({1, 1}, 0.25), a, b);
  ASSERT_TRUE(smoother.Update().accepted);
  const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
  EXPECT_LT((*smoother.NewestCovariance() - (4.0 + 16.0) * I).norm(), 1e-9);
  const std::vector<VariableId> both = {b, a};
  Eigen::Matrix4d expected;
  expected << 20.0 * I, 4.0 * I, 4.0 * I, 4.0 * I;
  EXPECT_LT((*smoother.Covariance(both) - expected).norm(), 1e-9);
  smoother.Fix(a);
  expected << 16.0 * I, 0.0 * I, 0.0 * I, 0.0 * I;
  EXPECT_LT((*smoother.Covariance(both) - expected).norm(), 1e-9);
}

TEST(SlidingWindowCovariance, CovarianceWithLandmarksIsThatOfTheGraph) {
  SlidingWindowSmoother smoother({.max_states = 6, .solve = Exact()});
  Walk walk(&smoother);
  for (int k = 0; k < 9; ++k) {
    walk.Advance();
    ASSERT_TRUE(smoother.Update().accepted);
  }
  const std::vector<VariableId> wanted = {walk.states[8], walk.states[5]};
  const Eigen::MatrixXd expected = *smoother.graph().Covariance(wanted);
  EXPECT_LT((*smoother.Covariance(wanted) - expected).norm(), 1e-12 * expected.norm());
  // Covariance of a landmark, which is eliminated, and with an otherwise unconstrained state.
  const std::vector<VariableId> landmark = {walk.landmarks.back(), walk.states[8]};
  EXPECT_LT((*smoother.Covariance(landmark) - *smoother.graph().Covariance(landmark)).norm(), 1e-9);
  smoother.AddState(700, Vector2(0, 0));
  EXPECT_LT((*smoother.Covariance(wanted) - expected).norm(), 1e-9 * expected.norm());
}

// Eliminates landmarks in the same way as the odometry's window does.
SlidingWindowOptions Projected() {
  return {.max_states = 6, .landmarks = LandmarkPolicy::kMarginalize};
}

TEST(SlidingWindowCovariance, AnUpdateReturnsTheCovarianceOfALaterQuery) {
  for (const LinearSolver solver :
       {LinearSolver::kVariableProjection, LinearSolver::kCompactSchur, LinearSolver::kAuto}) {
    SlidingWindowOptions options = Projected();
    options.solve.linear_solver = solver;
    SlidingWindowSmoother smoother(options);
    Walk walk(&smoother);
    for (int k = 0; k < 9; ++k) {
      walk.Advance();
      std::vector<VariableId> wanted = {walk.states.back()};
      if (k > 0) wanted.push_back(walk.states[walk.states.size() - 2]);
      const UpdateReport report = smoother.Update(wanted);
      ASSERT_TRUE(report.accepted) << report.message;
      ASSERT_TRUE(report.covariance);
      const Eigen::MatrixXd after = *smoother.Covariance(wanted);
      EXPECT_LT((*report.covariance - after).norm(), 1e-9 * after.norm()) << k;
    }
    EXPECT_FALSE(smoother.Update().covariance);
  }
}

// All observations of landmarks are invariant to a common translation, and only a weak prior fixes
// it. The landmarks' contribution to this direction must cancel to the last digit, or the direction
// appears observable.
TEST(SlidingWindowCovariance, LandmarksAddNoInformationOnTheirCommonPosition) {
  for (const double sigma : {1.0, 100.0, 1e4}) {
    SlidingWindowSmoother smoother(Projected());
    RandomStates random(3);
    std::vector<Variable<Vector2>> states;
    for (int k = 0; k < 5; ++k) states.push_back(smoother.AddState(k, Vector2(k, 0)));
    smoother.AddFactor(MakePrior({0, 0}, 1.0 / sigma), states[0]);
    for (int j = 0; j < 300; ++j) {
      const Vector2 x(random.Uniform(-9, 9), random.Uniform(-9, 9));
      const auto landmark = smoother.AddLandmark(x);
      for (int k = 0; k < 5; ++k) {
        smoother.AddFactor(MakeStep(x - Vector2(k, 0), 100.0), states[static_cast<std::size_t>(k)],
                           landmark);
      }
    }
    const std::vector<VariableId> wanted = {states.back()};
    const UpdateReport report = smoother.Update(wanted);
    ASSERT_TRUE(report.accepted) << report.message;
    ASSERT_TRUE(report.covariance);
    // The tolerance covers rounding of 300 * 1e4 / 5 relative to 1e-8.
    EXPECT_NEAR(std::sqrt((*report.covariance)(0, 0)), sigma, 0.01 * sigma);
  }
}

// Observes x along one axis only: the landmark has an unobservable direction, in which the damping
// of the solver must not count as information.
struct Along {
  template <class S>
  bool operator()(const S* x_i, const S* x_j, S* r) const {
    r[0] = x_j[0] - x_i[0];
    return true;
  }
};

TEST(SlidingWindowCovariance, AnUnobservableLandmarkAddsNoInformation) {
  SlidingWindowSmoother smoother(Projected());
  const auto state = smoother.AddState(0, Vector2(1, 1));
  smoother.AddFactor(MakePrior({0, 0}, 0.5), state);
  const auto landmark = smoother.AddLandmark(Vector2(3, 4));
  smoother.AddFactor(std::make_unique<ceres::AutoDiffCostFunction<Along, 1, 2, 2>>(new Along),
                     state, landmark);
  const std::vector<VariableId> wanted = {state};
  const UpdateReport report = smoother.Update(wanted);
  ASSERT_TRUE(report.accepted) << report.message;
  ASSERT_TRUE(report.covariance);
  EXPECT_LT((*report.covariance - 4.0 * Eigen::Matrix2d::Identity()).norm(), 1e-12);
}

TEST(SlidingWindowCovariance, OfAVariableThatIsNotThereOrTwiceIsRefusedBeforeAnythingIsDone) {
  SlidingWindowSmoother smoother(Projected()), other(Projected());
  Walk walk(&smoother);
  walk.Advance();
  const std::vector<VariableId> twice = {walk.states[0], walk.states[0]};
  const std::vector<VariableId> foreign = {other.AddState(0, Vector2(0, 0))};
  EXPECT_THROW(smoother.Update(twice), InvalidArgument);
  EXPECT_THROW(smoother.Update(foreign), InvalidArgument);
  EXPECT_THROW(smoother.Covariance(twice), InvalidArgument);
  EXPECT_TRUE(smoother.Update().accepted);
  EXPECT_TRUE(smoother.Contains(walk.states[0]));
}

TEST(SlidingWindowCovariance, ARefusedUpdateReturnsNoCovariance) {
  SlidingWindowOptions options = Projected();
  options.max_error = 3.0;
  SlidingWindowSmoother smoother(options);
  Walk walk(&smoother);
  walk.Advance();
  ASSERT_TRUE(smoother.Update().accepted);
  smoother.AddFactor(MakePrior({100, 0}, 1.0), walk.states[0]);
  const std::vector<VariableId> wanted = {walk.states[0]};
  const UpdateReport report = smoother.Update(wanted);
  EXPECT_FALSE(report.accepted);
  EXPECT_FALSE(report.covariance);
}

// Can be evaluated below one only.
struct Below {
  template <class S>
  bool operator()(const S* x, S* r) const {
    if (x[0] >= S(1.0)) throw std::runtime_error("one and more");
    r[0] = S(1e-3) * x[0];
    return true;
  }
};

TEST(SlidingWindowCovariance, AFactorThatThrowsIsOneThatCannotBeEvaluated) {
  SlidingWindowSmoother smoother(Projected());
  Walk walk(&smoother);
  walk.Advance();
  const auto state = smoother.AddState(0, Vector2(0, 0));
  smoother.AddFactor(MakePrior({0, 0}), state);
  smoother.AddFactor(std::make_unique<ceres::AutoDiffCostFunction<Below, 1, 2>>(new Below), state);
  ASSERT_TRUE(smoother.Update().accepted);
  smoother.SetValue(state, Vector2(2, 0));
  const std::vector<VariableId> wanted = {walk.states[0]};
  EXPECT_FALSE(smoother.Covariance(wanted));
}

// Type of absolute constraint of a walk with points: its gauge is free, or fixed in part or
// completely.
enum class Held { kNothing, kPosition, kPose };
struct PoseWalk {
  PoseWalk(unsigned seed, Held held, double sigma, SlidingWindowSmoother* s) : smoother(s) {
    RandomStates random(seed);
    std::vector<Pose> truth;
    for (int k = 0; k < 8; ++k) {
      truth.push_back(Pose::FromTangent({0.2 * k, 0.0, 0.0}, random.Vector(0.3)));
      states.push_back(smoother->AddState(k, truth.back()));
    }
    if (held == Held::kPosition || held == Held::kPose) {
      Eigen::Matrix<double, 6, 1> weights = Eigen::Matrix<double, 6, 1>::Zero();
      weights.head(held == Held::kPose ? 6 : 3).setConstant(1.0 / sigma);
      smoother->AddFactor(
          std::make_unique<PosePrior>(truth[0], Eigen::Matrix<double, 6, 6>(weights.asDiagonal())),
          states[0]);
    }
    for (int j = 0; j < 40; ++j) {
      const Point x = random.Vector(4.0) + Point(0, 0, 6.0);
      const auto landmark = smoother->AddLandmark(x);
      for (std::size_t k = 0; k < truth.size(); ++k) {
        smoother->AddFactor(MakeObservation(truth[k].Inverse() * x, 300.0), states[k], landmark);
      }
    }
  }
  SlidingWindowSmoother* smoother;
  std::vector<Variable<Pose>> states;
};

TEST(SlidingWindowCovariance, OfAWindowWithAnOpenGaugeThereIsNone) {
  for (const Held held : {Held::kNothing, Held::kPosition}) {
    for (unsigned seed = 0; seed < 10; ++seed) {
      for (const bool first_estimates : {false, true}) {
        SlidingWindowOptions options = Projected();
        options.max_states = 5;
        options.marginalization.first_estimate_jacobians = first_estimates;
        SlidingWindowSmoother smoother(options);
        const PoseWalk walk(seed, held, 1.0, &smoother);
        const std::vector<VariableId> wanted = {walk.states.back()};
        const UpdateReport report = smoother.Update(wanted);
        ASSERT_TRUE(report.accepted) << report.message;
        EXPECT_FALSE(report.covariance) << seed << ": " << report.covariance->trace();
        // Three states have left by now, and the prior does not fix the position of the window
        // either.
        EXPECT_FALSE(smoother.NewestCovariance()) << seed;
        EXPECT_FALSE(smoother.graph().Covariance(wanted)) << seed;
        EXPECT_FALSE(smoother.Update(wanted).covariance) << seed;
      }
    }
  }
}

// This holds however weak the prior is in comparison with the relative information of the
// landmarks.
TEST(SlidingWindowCovariance, OfAWindowThatAWeakPriorHoldsItIsThatOfThePrior) {
  for (const double sigma : {1e-2, 1.0, 100.0, 1e3}) {
    SlidingWindowSmoother smoother(Projected());
    const PoseWalk walk(3, Held::kPose, sigma, &smoother);
    const std::vector<VariableId> wanted = {walk.states.front()};
    const UpdateReport report = smoother.Update(wanted);
    ASSERT_TRUE(report.accepted) << report.message;
    ASSERT_TRUE(report.covariance) << sigma;
    EXPECT_NEAR(std::sqrt((*report.covariance)(0, 0)), sigma, 0.01 * sigma);
    EXPECT_NEAR(std::sqrt((*report.covariance)(5, 5)), sigma, 0.01 * sigma);
  }
}

// A chain of relative steps only: the absolute information on the requested state is rounding.
TEST(SlidingWindowCovariance, AChainWithoutAPriorHasNoCovariance) {
  for (int length = 2; length <= 10; ++length) {
    SlidingWindowSmoother smoother;
    std::vector<Variable<Vector2>> states;
    RandomStates random(7);
    for (int k = 0; k < length; ++k) {
      states.push_back(smoother.AddState(k, Vector2(0, 0)));
      for (int i = 0; i < k; ++i) {
        smoother.AddFactor(MakeStep({1, 0}, random.Uniform(0.01, 300.0)),
                           states[static_cast<std::size_t>(i)], states.back());
      }
    }
    const std::vector<VariableId> wanted = {states[0]};
    const UpdateReport report = smoother.Update(wanted);
    ASSERT_TRUE(report.accepted) << report.message;
    EXPECT_FALSE(report.covariance) << length;
    EXPECT_FALSE(smoother.graph().Covariance(wanted)) << length;
  }
}

}  // namespace
}  // namespace highwall::sliding_window_covariance_test
