#include <highwall/core/sliding_window_smoother.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>

#include "plane_steps.h"
#include "plane_walk.h"

namespace highwall::sliding_window_smoother_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
// Evaluates to the failure given by its kind.
class Bad final : public ceres::SizedCostFunction<2, 2> {
 public:
  enum class Kind { kFalse, kThrows, kNanResidual, kNanJacobian };
  explicit Bad(Kind kind) : kind_(kind) {}
  bool Evaluate(double const* const*, double* r, double** J) const override {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    if (kind_ == Kind::kFalse) return false;
    if (kind_ == Kind::kThrows) throw std::runtime_error("the sensor is on fire");
    r[0] = r[1] = kind_ == Kind::kNanResidual ? nan : 1.0;
    if (J != nullptr && J[0] != nullptr) {
      for (int i = 0; i < 4; ++i) J[0][i] = kind_ == Kind::kNanJacobian ? nan : 1.0;
    }
    return true;
  }

 private:
  Kind kind_;
};

TEST(SlidingWindowSmoother, ALinearGaussianRunEqualsTheBatchSolution) {
  // The window contains all observers of a landmark until the landmark leaves, so no factor is
  // dropped.
  SlidingWindowSmoother batch({.max_states = 1000, .solve = Exact()});
  SlidingWindowSmoother lag({.max_states = 6, .solve = Exact()});
  Walk batch_walk(&batch), lag_walk(&lag);
  for (int k = 0; k < 60; ++k) {
    batch_walk.Advance();
    lag_walk.Advance();
    ASSERT_TRUE(batch.Update().accepted);
    const UpdateReport report = lag.Update();
    ASSERT_TRUE(report.accepted) << report.message;
    EXPECT_EQ(report.dropped_factors, 0);
    for (std::size_t i = 0; i < lag_walk.states.size(); ++i) {
      if (!lag.Contains(lag_walk.states[i])) continue;
      EXPECT_LT((lag.Value(lag_walk.states[i]) - batch.Value(batch_walk.states[i])).norm(), 1e-9);
    }
    EXPECT_LT((*lag.NewestCovariance() - *batch.NewestCovariance()).norm(), 1e-9);
  }
  EXPECT_EQ(lag.Stamps().size(), 6u);
  EXPECT_EQ(lag.Stamps().front(), 5400);
  EXPECT_EQ(batch.Stamps().size(), 60u);
}

TEST(SlidingWindowSmoother, EqualsTheBatchSolutionWithLandmarksThatStayInThePrior) {
  // A landmark added as calibration never leaves: the prior links it to the states.
  struct ConstrainedWalk final : Walk {
    using Walk::Walk;
    Variable<Vector2> AddLandmark(const Vector2& x) override { return smoother->AddCalibration(x); }
  };
  SlidingWindowSmoother batch({.max_states = 1000, .solve = Exact()});
  SlidingWindowSmoother lag({.max_states = 2, .solve = Exact()});
  ConstrainedWalk batch_walk(&batch), lag_walk(&lag);
  for (int k = 0; k < 30; ++k) {
    batch_walk.Advance();
    lag_walk.Advance();
    batch.Update();
    ASSERT_TRUE(lag.Update().accepted);
  }
  for (std::size_t j = 0; j < lag_walk.landmarks.size(); ++j) {
    EXPECT_LT((lag.Value(lag_walk.landmarks[j]) - batch.Value(batch_walk.landmarks[j])).norm(),
              1e-9);
  }
}

TEST(SlidingWindowSmoother, SolvesAgainFromWhereItIs) {
  SlidingWindowSmoother smoother({.solve = {.max_iterations = 50, .function_tolerance = 1e-12}});
  RandomStates random(4);
  Variable<Pose> last;
  for (int k = 0; k < 5; ++k) {
    const auto x = smoother.AddState(Stamp{k}, random.RandomPose(1.0, 0.5));
    smoother.AddFactor(
        std::make_unique<PosePrior>(random.RandomPose(1.0, 0.5), Matrix6::Identity()), x);
    if (k > 0) {
      smoother.AddFactor(
          std::make_unique<RelativePose>(random.RandomPose(1.0, 0.5), Matrix6::Identity()), last,
          x);
    }
    last = x;
  }
  const UpdateReport cold = smoother.Update(), warm = smoother.Update();
  EXPECT_GT(cold.solve.iterations, 4);
  EXPECT_LE(warm.solve.iterations, 2);
  EXPECT_EQ(warm.solve.initial_cost, cold.solve.final_cost);
}

TEST(SlidingWindowSmoother, LagsBySeconds) {
  SlidingWindowSmoother smoother({.max_states = 100, .max_seconds = 1.0});
  for (int k = 0; k < 8; ++k) {
    const auto x = smoother.AddState(Stamp{k} * 400'000'000, 1.0 * k);
    smoother.AddFactor(std::make_unique<VectorPrior<1>>(Eigen::Matrix<double, 1, 1>(k),
                                                        Eigen::Matrix<double, 1, 1>(1.0)),
                       x);
    const UpdateReport report = smoother.Update();
    EXPECT_TRUE(report.accepted);
    EXPECT_EQ(report.left.size(), k < 3 ? 0u : 1u);
  }
  EXPECT_EQ(smoother.Stamps(), (std::vector<Stamp>{2'000'000'000, 2'400'000'000, 2'800'000'000}));
}

TEST(SlidingWindowSmoother, StatesOfOneStampLeaveTogether) {
  SlidingWindowSmoother smoother({.max_states = 2});
  std::vector<Variable<Pose>> poses;
  for (int k = 0; k < 3; ++k) {
    poses.push_back(smoother.AddState(Stamp{k}, Pose()));
    const auto velocity = smoother.AddState(Stamp{k}, Eigen::Vector3d(1, 2, 3));
    smoother.AddFactor(std::make_unique<PosePrior>(Pose(), Matrix6::Identity()), poses.back());
    EXPECT_EQ(smoother.Find<Pose>(k), poses.back());
    EXPECT_EQ(smoother.Find<Eigen::Vector3d>(k), velocity);
    EXPECT_FALSE(smoother.Find<double>(k));
    smoother.Update();
  }
  EXPECT_FALSE(smoother.Contains(poses[0]));
  EXPECT_TRUE(smoother.Contains(poses[1]));
  EXPECT_EQ(smoother.StatesAt(1).size(), 2u);
  EXPECT_TRUE(smoother.StatesAt(0).empty());
  EXPECT_THROW(smoother.Value(poses[0]), InvalidArgument);
}

TEST(SlidingWindowSmoother, ABadFactorRejectsTheUpdateAndKeepsTheState) {
  const std::pair<Bad::Kind, const char*> cases[] = {
      {Bad::Kind::kFalse, "cannot be evaluated"},
      {Bad::Kind::kThrows, "the sensor is on fire"},
      {Bad::Kind::kNanResidual, "a residual that is not finite"},
      {Bad::Kind::kNanJacobian, "a Jacobian that is not finite"}};
  SlidingWindowSmoother smoother({.max_states = 3});
  const auto first = smoother.AddState(0, Vector2(1, 1));
  smoother.AddFactor(MakePrior({0, 0}), first);
  ASSERT_TRUE(smoother.Update().accepted);
  const Vector2 before = smoother.Value(first);
  for (const auto& [kind, why] : cases) {
    const auto second = smoother.AddState(1, Vector2(5, 5));
    const FactorId good = smoother.AddFactor(MakeStep({1, 0}), first, second);
    smoother.AddFactor(std::make_unique<Bad>(kind), second);
    const UpdateReport report = smoother.Update();
    EXPECT_FALSE(report.accepted);
    EXPECT_NE(report.message.find(why), std::string::npos) << report.message;
    EXPECT_NE(report.message.find("factor 2 of the 2"), std::string::npos) << report.message;
    EXPECT_EQ(smoother.Value(first), before);
    EXPECT_FALSE(smoother.Contains(second));
    EXPECT_FALSE(smoother.Contains(good));
    EXPECT_EQ(smoother.graph().NumFactors(), 1u);
    EXPECT_EQ(smoother.Stamps(), std::vector<Stamp>{0});
  }
  // The smoother continues afterwards.
  const auto second = smoother.AddState(1, Vector2(5, 5));
  smoother.AddFactor(MakeStep({1, 0}), first, second);
  EXPECT_TRUE(smoother.Update().accepted);
  EXPECT_LT((smoother.Value(second) - Vector2(1, 0)).norm(), 1e-3);
}

TEST(SlidingWindowSmoother, AnAbsurdMeasurementRejectsTheUpdateIfThereIsALimit) {
  SlidingWindowSmoother smoother({.max_error = 5.0});
  const auto x = smoother.AddState(0, Vector2(0, 0));
  smoother.AddFactor(MakePrior({0, 0}, 10.0), x);
  ASSERT_TRUE(smoother.Update().accepted);
  smoother.AddFactor(MakePrior({1e6, 0}, 1.0), x);
  const UpdateReport report = smoother.Update();
  EXPECT_FALSE(report.accepted);
  EXPECT_NE(report.message.find("max_error"), std::string::npos) << report.message;
  EXPECT_LT(smoother.Value(x).norm(), 1e-9);
  smoother.AddFactor(MakePrior({0.1, 0}, 1.0), x);
  EXPECT_TRUE(smoother.Update().accepted);
}

TEST(SlidingWindowSmoother, AFailedSolveKeepsTheState) {
  SlidingWindowSmoother smoother;
  const auto x = smoother.AddState(0, Pose());
  smoother.AddFactor(std::make_unique<PosePrior>(Pose(), Matrix6::Identity()), x);
  const auto a = smoother.AddLandmark(Pose()), b = smoother.AddLandmark(Pose());
  smoother.AddFactor(std::make_unique<RelativePose>(Pose(), Matrix6::Identity()), a, b);
  const UpdateReport report = smoother.Update();
  EXPECT_FALSE(report.accepted);
  EXPECT_NE(report.message.find("solver failed"), std::string::npos) << report.message;
  EXPECT_EQ(smoother.graph().NumVariables(), 0u);
}

TEST(SlidingWindowSmoother, VariablesWithoutFactorsStayAndLeaveTheWindow) {
  SlidingWindowSmoother smoother({.max_states = 2});
  std::vector<Variable<Vector2>> states;
  const auto lost = smoother.AddLandmark(Vector2(7, 7));
  const auto calibration = smoother.AddCalibration(3.0);
  for (int k = 0; k < 5; ++k) {
    states.push_back(smoother.AddState(Stamp{k}, Vector2(k, k)));
    const UpdateReport report = smoother.Update();
    EXPECT_TRUE(report.accepted) << report.message;
    EXPECT_EQ(smoother.Value(states.back()), Vector2(k, k));
    EXPECT_FALSE(smoother.NewestCovariance());  // it is unconstrained
  }
  EXPECT_FALSE(smoother.Contains(lost));  // an unobserved landmark is removed immediately
  EXPECT_TRUE(smoother.Contains(calibration));
  EXPECT_EQ(smoother.graph().NumVariables(), 3u);
  EXPECT_EQ(smoother.graph().NumFactors(), 0u);
}

TEST(SlidingWindowSmoother, EmptyUpdatesDoNothing) {
  SlidingWindowSmoother smoother;
  EXPECT_TRUE(smoother.Update().accepted);
  EXPECT_TRUE(smoother.Stamps().empty());
  EXPECT_FALSE(smoother.NewestCovariance());
}

TEST(SlidingWindowSmoother, LandmarksInViewStayAndLostOnesGoIntoThePrior) {
  SlidingWindowSmoother smoother({.max_states = 2});
  const auto tracked = smoother.AddLandmark(Vector2(0, 0)),
             lost = smoother.AddLandmark(Vector2(0, 0));
  Variable<Vector2> last;
  UpdateReport report;
  for (int k = 0; k < 3; ++k) {
    const auto x = smoother.AddState(Stamp{k}, Vector2(k, 0));
    if (k == 0) smoother.AddFactor(MakePrior({0, 0}), x);
    if (k > 0) smoother.AddFactor(MakeStep({1, 0}), last, x);
    smoother.AddFactor(MakeStep({3.0 - k, 1}), x, tracked);
    if (k < 2) smoother.AddFactor(MakeStep({3.0 - k, -1}), x, lost);
    last = x;
    report = smoother.Update();
  }
  EXPECT_TRUE(smoother.Contains(tracked));
  EXPECT_FALSE(smoother.Contains(lost));
  EXPECT_EQ(report.dropped_factors, 1);
  EXPECT_EQ(report.left, std::vector<Stamp>{0});
  ASSERT_EQ(report.reports.size(), 1u);
  EXPECT_EQ(report.reports[0].factors, 4);  // prior, step and both observations of `lost`
  EXPECT_EQ(report.removed.size(), 2u);

  SlidingWindowSmoother all({.max_states = 1, .landmarks = LandmarkPolicy::kMarginalize});
  const auto a = all.AddState(0, Vector2(0, 0));
  const auto point = all.AddLandmark(Vector2(0, 0));
  all.AddFactor(MakePrior({0, 0}), a);
  all.AddFactor(MakeStep({1, 1}), a, point);
  all.Update();
  const auto b = all.AddState(1, Vector2(0, 0));
  all.AddFactor(MakeStep({0, 1}), b, point);
  report = all.Update();
  EXPECT_FALSE(all.Contains(point));
  EXPECT_EQ(report.dropped_factors, 0);
  EXPECT_LT((all.Value(b) - Vector2(1, 0)).norm(), 1e-3);
  // Variance 1 of a, plus 1 of each observation.
  EXPECT_LT((*all.NewestCovariance() - 3.0 * Eigen::Matrix2d::Identity()).norm(), 1e-9);
}

TEST(SlidingWindowSmoother, LeastInformationRemovesTheRedundantState) {
  // States 1 and 2 are at the same place, and state 2 has a weak measurement only.
  SlidingWindowSmoother smoother(
      {.max_states = 4, .leaving = LeavingPolicy::kLeastInformation, .protected_states = 2});
  std::vector<Variable<Vector2>> x;
  UpdateReport report;
  for (int k = 0; k < 5; ++k) {
    x.push_back(smoother.AddState(Stamp{k}, Vector2(k, 0)));
    const double weight = k == 2 ? 0.01 : 1.0;
    if (k == 0) smoother.AddFactor(MakePrior({0, 0}), x[0]);
    if (k == 1) smoother.AddFactor(MakeStep({1, 0}), x[0], x[1]);
    if (k == 2) smoother.AddFactor(MakeStep({1, 0}, weight), x[1], x[2]);
    if (k == 3) smoother.AddFactor(MakeStep({2, 0}), x[1], x[3]);
    if (k == 4) smoother.AddFactor(MakeStep({1, 0}), x[3], x[4]);
    report = smoother.Update();
    ASSERT_TRUE(report.accepted) << report.message;
  }
  EXPECT_EQ(report.left, std::vector<Stamp>{2});
  ASSERT_EQ(report.information_loss.size(), 3u);
  EXPECT_LT(report.information_loss[2].second, 0.1 * report.information_loss[1].second);
  EXPECT_EQ(smoother.Stamps(), (std::vector<Stamp>{0, 1, 3, 4}));
}

TEST(SlidingWindowSmoother, TheOldestLeavesWhereAllOthersAreProtected) {
  // State 1 has a weak measurement only, but is among the newest five.
  SlidingWindowSmoother smoother(
      {.max_states = 2, .leaving = LeavingPolicy::kLeastInformation, .protected_states = 5});
  const auto a = smoother.AddState(0, Vector2(0, 0)), b = smoother.AddState(1, Vector2(1, 0)),
             c = smoother.AddState(2, Vector2(2, 0));
  smoother.AddFactor(MakePrior({0, 0}), a);
  smoother.AddFactor(MakeStep({1, 0}, 0.01), a, b);
  smoother.AddFactor(MakeStep({2, 0}), a, c);
  const UpdateReport report = smoother.Update();
  ASSERT_TRUE(report.accepted) << report.message;
  EXPECT_EQ(report.left, std::vector<Stamp>{0});
  EXPECT_EQ(report.information_loss.size(), 1u);
}

TEST(SlidingWindowSmoother, KeepsToItsBudget) {
  // Each evaluation sleeps, so this solve takes much longer without a time budget.
  class SlowCost final : public ceres::SizedCostFunction<1, 1> {
   public:
    bool Evaluate(double const* const* x, double* r, double** J) const override {
      usleep(2000);
      r[0] = std::sqrt(std::sqrt(1.0 + x[0][0] * x[0][0]));
      if (J != nullptr && J[0] != nullptr) J[0][0] = 0.5 * x[0][0] / std::pow(r[0], 3.0);
      return true;
    }
  };
  const SolveOptions endless = {.max_iterations = 200,
                                .function_tolerance = 0.0,
                                .gradient_tolerance = 0.0,
                                .parameter_tolerance = 0.0,
                                .initial_trust_region_radius = 1e-3};
  SlidingWindowSmoother smoother({.budget_ms = 40.0, .solve = endless});
  const auto x = smoother.AddState(0, 100.0);
  smoother.AddFactor(std::make_unique<SlowCost>(), x);
  const UpdateReport report = smoother.Update();
  EXPECT_TRUE(report.accepted);
  EXPECT_EQ(report.solve.status, SolveStatus::kLimit);
  EXPECT_LT(report.solve.iterations, 30);  // each takes at least 4 ms
}

TEST(SlidingWindowSmoother, OptionsOutOfRangeAreRefusedByName) {
  const auto message = [](const SlidingWindowOptions& options) -> std::string {
    try {
      SlidingWindowSmoother smoother(options);
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message({.max_states = 0}).find("max_states"), std::string::npos);
  EXPECT_NE(message({.max_seconds = 0.0}).find("max_seconds"), std::string::npos);
  EXPECT_NE(message({.budget_ms = NAN}).find("budget_ms"), std::string::npos);
  EXPECT_NE(message({.protected_states = 0}).find("protected_states"), std::string::npos);
  EXPECT_NE(message({.max_error = -1.0}).find("max_error"), std::string::npos);
  EXPECT_EQ(message({}), "");
  EXPECT_STREQ(ToString(LeavingPolicy::kLeastInformation), "least_information");
  EXPECT_STREQ(ToString(LandmarkPolicy::kKeepTracked), "keep_tracked");
}

class SavedWindow : public ::testing::Test {
 protected:
  SavedWindow()
      : path_(std::filesystem::temp_directory_path() /
              ("highwall_window_" + std::to_string(::getpid()))) {}
  ~SavedWindow() override { std::filesystem::remove(path_); }

  // Poses with odometry and a landmark, a calibration and a fixed state.
  static SlidingWindowSmoother Example(const SlidingWindowOptions& options) {
    SlidingWindowSmoother smoother(options);
    RandomStates random(9);
    const auto scale = smoother.AddCalibration(1.25);
    smoother.AddFactor(std::make_unique<VectorPrior<1>>(Eigen::Matrix<double, 1, 1>(1.3),
                                                        Eigen::Matrix<double, 1, 1>(3.0)),
                       scale);
    for (int k = 0; k < 6; ++k) Extend(&smoother, k, &random);
    return smoother;
  }
  static void Extend(SlidingWindowSmoother* smoother, int k, RandomStates* random) {
    const auto x = smoother->AddState(Stamp{k}, random->RandomPose(1.0, 0.3));
    if (k == 0) {
      smoother->AddFactor(std::make_unique<PosePrior>(Pose(), Matrix6::Identity()), x);
    } else {
      smoother->AddFactor(
          std::make_unique<RelativePose>(random->RandomPose(0.3, 0.1), 2.0 * Matrix6::Identity()),
          *smoother->Find<Pose>(k - 1), x);
    }
    EXPECT_TRUE(smoother->Update().accepted);
  }
  std::string Text() const {
    std::ifstream file(path_);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }
  void WriteText(const std::string& text) const { std::ofstream(path_) << text; }
  std::string LoadError() const {
    try {
      SlidingWindowSmoother::Load<Pose, double>(path_);
    } catch (const IoError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path path_;
};

TEST_F(SavedWindow, LoadsWithTheSameValuesAndCovariance) {
  const SlidingWindowOptions options = {.max_states = 4};
  SlidingWindowSmoother smoother = Example(options);
  smoother.Save(path_);
  SlidingWindowSmoother loaded = SlidingWindowSmoother::Load<Pose, double>(path_, options);
  EXPECT_EQ(loaded.Stamps(), smoother.Stamps());
  for (const Stamp stamp : smoother.Stamps()) {
    EXPECT_EQ(Block(loaded.Value(*loaded.Find<Pose>(stamp))),
              Block(smoother.Value(*smoother.Find<Pose>(stamp))));
  }
  EXPECT_EQ(loaded.graph().NumVariables(), 5u);
  EXPECT_EQ(loaded.graph().NumFactors(), 1u);
  EXPECT_LT((*loaded.NewestCovariance() - *smoother.NewestCovariance()).norm(), 1e-9);
}

TEST_F(SavedWindow, ContinuesAsIfItHadNeverBeenSaved) {
  const SlidingWindowOptions options = {.max_states = 4, .solve = Exact()};
  SlidingWindowSmoother smoother = Example(options);
  smoother.Save(path_);
  SlidingWindowSmoother loaded = SlidingWindowSmoother::Load<Pose, double>(path_, options);
  RandomStates a(3), b(3);
  Extend(&smoother, 6, &a);
  Extend(&loaded, 6, &b);
  // The loaded factors are linearized. They are equal while the window does not move, and here it
  // hardly moves, because odometry alone leaves no residual.
  const Pose difference =
      loaded.Value(*loaded.Find<Pose>(6)).Inverse() * smoother.Value(*smoother.Find<Pose>(6));
  EXPECT_LT(difference.p().norm(), 1e-6);
  EXPECT_LT(difference.Angle(), 1e-6);
}

TEST_F(SavedWindow, SavingTwiceGivesTheSameBytes) {
  const SlidingWindowSmoother smoother = Example({.max_states = 4});
  smoother.Save(path_);
  const std::string first = Text();
  SlidingWindowSmoother::Load<double, Pose>(path_);
  smoother.Save(path_);
  EXPECT_EQ(Text(), first);
}

TEST_F(SavedWindow, FixedVariablesStayFixed) {
  SlidingWindowSmoother smoother;
  const auto x = smoother.AddState(3, Pose());
  smoother.AddFactor(std::make_unique<PosePrior>(Pose(), Matrix6::Identity()), x);
  smoother.Fix(x);
  smoother.Save(path_);
  const auto loaded = SlidingWindowSmoother::Load<Pose>(path_);
  EXPECT_TRUE(loaded.graph().IsFixed(*loaded.Find<Pose>(3)));
}

TEST_F(SavedWindow, DamagedFilesAreRefusedWithTheLine) {
  Example({.max_states = 4}).Save(path_);
  const std::string text = Text();
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    WriteText(changed);
    return LoadError();
  };
  const std::string name = path_.string();
  EXPECT_EQ(replaced("highwall_sliding_window 1", "highwall_sliding_window 2"),
            name + ":1: version 2 is not known; this is version 1");
  EXPECT_EQ(replaced("highwall_sliding_window", "solid"),
            name + ":1: expected 'highwall_sliding_window'");
  EXPECT_EQ(replaced("variables 5", "variables -1"),
            name + ":2: the number of variables is out of range");
  EXPECT_EQ(replaced("variables 5", "variables 7"), name + ":8: expected 'state' or 'calibration'");
  EXPECT_EQ(replaced("1.3", "nan"), name + ":3: a number is not finite");
  EXPECT_NE(replaced("1.3", "?1.3").find(":3: expected a number, found '?1.3"), std::string::npos);
  EXPECT_NE(replaced("variables 5", "variables 5x").find(":2: "), std::string::npos);
  EXPECT_EQ(
      replaced("\nend\n", "\n"),
      name + ":" + std::to_string(std::count(text.begin(), text.end(), '\n')) + ": ends early");
  EXPECT_EQ(replaced("block 0 ", "block 5 "), name + ":9: there is no such variable");
  for (std::size_t length = 0; length + 1 < text.size(); length += 37) {
    WriteText(text.substr(0, length));
    EXPECT_NE(LoadError(), "") << length;
  }
  WriteText(text);
  EXPECT_EQ(LoadError(), "");
  EXPECT_THROW(SlidingWindowSmoother::Load<Pose>(path_), IoError);  // the file contains a double
  std::filesystem::remove(path_);
  EXPECT_NE(LoadError().find("cannot be read"), std::string::npos);
}

// The quaternion belongs to a pose that is a value or the linearization point of a prior.
TEST_F(SavedWindow, AQuaternionThatIsNoRotationIsRefused) {
  Example({.max_states = 4}).Save(path_);
  const std::string text = Text();
  for (const std::string begin : {"\nstate ", "\nblock 1 7 "}) {
    const std::size_t end = text.find('\n', text.find(begin) + 1);
    ASSERT_NE(text.find(begin), std::string::npos) << text;
    for (const std::string q : {"0 0 0 0", "0 0 0 2", "1e200 0 0 0"}) {
      std::size_t at = end;
      for (int i = 0; i < 4; ++i) at = text.rfind(' ', at - 1);
      WriteText(text.substr(0, at + 1) + q + text.substr(end));
      EXPECT_NE(LoadError().find("not of unit length"), std::string::npos) << LoadError();
      EXPECT_EQ(LoadError().find(path_.string()), 0u);
    }
  }
}

}  // namespace
}  // namespace highwall::sliding_window_smoother_test
