// Updates of the smoother in which states leave and an operation fails.
#include <highwall/core/sliding_window_smoother.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include "plane_steps.h"

namespace highwall::sliding_window_leaving_test {
namespace {

// A prior at (0, 0) whose evaluation fails once the flag `broken` is set.
class Breakable final : public ceres::SizedCostFunction<2, 2> {
 public:
  explicit Breakable(const bool* broken) : broken_(broken) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    for (int k = 0; k < 2; ++k) r[k] = x[0][k];
    if (J != nullptr && J[0] != nullptr) {
      J[0][0] = J[0][3] = 1.0;
      J[0][1] = J[0][2] = 0.0;
    }
    return !*broken_;
  }

 private:
  const bool* broken_;
};

class LeavingStates : public ::testing::Test {
 protected:
  // Starts at the solution, so a factor that breaks after the first evaluation breaks the
  // marginalization.
  SlidingWindowSmoother Make(LeavingPolicy leaving) {
    SolveOptions solve = Exact();
    solve.on_iteration = [this](int, double) { broken_ = break_; };
    return SlidingWindowSmoother(
        {.max_states = 2, .leaving = leaving, .protected_states = 1, .solve = solve});
  }
  void AddState(Stamp stamp, bool breakable, SlidingWindowSmoother* smoother) {
    states_.push_back(smoother->AddState(stamp, Vector2(0, 0)));
    const auto keep = [&](const FactorId& factor) { factors_.push_back(factor); };
    keep(smoother->AddFactor(MakePrior({0, 0}), states_.back()));
    if (breakable) {
      keep(smoother->AddFactor(std::make_unique<Breakable>(&broken_), states_.back()));
    }
    // All states observe this landmark: it stays, and the factors to it are dropped.
    if (states_.size() == 1) in_view_ = smoother->AddLandmark(Vector2(0, 0));
    keep(smoother->AddFactor(MakeStep({0, 0}), states_.back(), in_view_));
    if (states_.size() == 1) return;
    keep(smoother->AddFactor(MakeStep({0, 0}), states_[states_.size() - 2], states_.back()));
    const auto landmark = smoother->AddLandmark(Vector2(0, 0));
    keep(smoother->AddFactor(MakeStep({0, 0}), states_[states_.size() - 2], landmark));
    keep(smoother->AddFactor(MakeStep({0, 0}), states_.back(), landmark));
  }

  bool break_ = false, broken_ = false;
  std::vector<Variable<Vector2>> states_;
  Variable<Vector2> in_view_;
  std::vector<FactorId> factors_;
};

TEST_F(LeavingStates, AnUpdateWhoseMarginalizationFailsChangesNothing) {
  for (const LeavingPolicy leaving :
       {LeavingPolicy::kOldestFirst, LeavingPolicy::kLeastInformation}) {
    for (const int added : {1, 2}) {  // the same number leaves, and the last one fails
      states_.clear();
      factors_.clear();
      break_ = broken_ = false;
      SlidingWindowSmoother smoother = Make(leaving);
      for (int k = 0; k < 2; ++k) AddState(k, k + 1 == added, &smoother);
      ASSERT_TRUE(smoother.Update().accepted);
      const std::vector<FactorId> before = factors_;
      const std::size_t variables = smoother.graph().NumVariables();
      for (int k = 0; k < added; ++k) AddState(2 + k, false, &smoother);
      break_ = true;
      const UpdateReport failed = smoother.Update();
      EXPECT_FALSE(failed.accepted);
      EXPECT_NE(failed.message.find("Marginalize"), std::string::npos) << failed.message;
      EXPECT_TRUE(failed.left.empty());
      EXPECT_TRUE(failed.removed.empty());
      EXPECT_EQ(smoother.Stamps(), (std::vector<Stamp>{0, 1}));
      EXPECT_EQ(smoother.graph().NumFactors(), before.size()) << added;
      EXPECT_EQ(smoother.graph().NumVariables(), variables);
      for (const FactorId& factor : before) EXPECT_TRUE(smoother.Contains(factor));
      for (const FactorId& factor : before) {
        for (const VariableId& variable : smoother.graph().VariablesOf(factor)) {
          const auto& factors = smoother.graph().FactorsOf(variable);
          EXPECT_EQ(std::count(factors.begin(), factors.end(), factor), 1);
        }
      }
      // The smoother continues afterwards.
      break_ = broken_ = false;
      states_.resize(2);
      for (int k = 0; k < added; ++k) AddState(2 + k, false, &smoother);
      const UpdateReport report = smoother.Update();
      EXPECT_TRUE(report.accepted) << report.message;
      EXPECT_EQ(report.left.size(), static_cast<std::size_t>(added));
      EXPECT_EQ(smoother.Stamps().size(), 2u);
    }
  }
}

}  // namespace
}  // namespace highwall::sliding_window_leaving_test
