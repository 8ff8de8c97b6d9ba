#include "loops/factor_adjuster.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <memory>
#include <mutex>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/relative_pose.h>

#include "loops/frame_alignment.h"
#include "loops/keyframe_graph.h"
#include "loops/loop_correction.h"
#include "support/id_literals.h"
#include "support/position_in_frame.h"
#include "support/ring_map.h"

namespace highwall::factor_adjuster_test {
namespace {

using testing::PositionInFrame;
using testing::RingMap;
using testing::operator""_kf;

constexpr int kKeyFrames = 200;  // 50 m
const Pose kT_FW = Pose::FromTangent({4.5e5, -2e6, 300}, {0, 0, 2.5});
const MeasurementModel kModel(testing::IdealSensor(), {});

// A ring that odometry does not close, and positions in a reference frame far away.
class FactorAdjusterTest : public ::testing::Test {
 protected:
  FactorAdjusterTest() {
    ring.Drift({.bias_rotation = 0.1 * M_PI / 180.0}, /*levelled=*/true);
    frame = map.factors().AddFrame({});
  }

  // Adds noisy positions of every n-th keyframe up to `last`.
  void Measure(double sigma, int every = 4, int last = kKeyFrames - 1) {
    std::mt19937 rng(7);
    std::normal_distribution<double> normal(0.0, sigma);
    for (int i = 0; i <= last; i += every) {
      const Pose T_KB = Pose::FromTangent({0.1, 0.0, 0.2}, {0, 0, 0});
      const double x = normal(rng), y = normal(rng), z = normal(rng);
      const Eigen::Vector3d p_F =
          kT_FW * (ring.truth[static_cast<std::size_t>(i)] * T_KB.p()) + Eigen::Vector3d(x, y, z);
      map.AddFactor({{{KeyFrameId(i), T_KB}}, frame, PositionInFrame(p_F, sigma), nullptr});
    }
  }

  // Returns the RMS error of the keyframes [m] in the reference frame.
  double Error() const {
    const Pose T_FW = *map.factors().T_FW(frame, kFirstSubmap);
    double sum = 0.0;
    for (std::size_t i = 0; i < ring.truth.size(); ++i) {
      const Pose& T_WC = map.keyframe(KeyFrameId(i))->T_WC;
      sum += (T_FW * T_WC.p() - kT_FW * ring.truth[i].p()).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(ring.truth.size()));
  }

  std::optional<FactorAdjustmentReport> Adjust(const UserFactorOptions& options, int threads = 0) {
    FactorAdjuster adjuster(kModel, options, {}, threads);
    return adjuster.BeginLast(map, kFirstSubmap, {}) ? adjuster.Finish(&map) : std::nullopt;
  }

  const UserFactorOptions defaults{};
  RingMap ring{kKeyFrames};
  Map& map = ring.map;
  ReferenceFrameId frame;
};

TEST_F(FactorAdjusterTest, TakesTheDriftOutOfTheWholeMap) {
  Measure(0.1);
  const std::optional<Pose> before = AlignFrame(map, frame, kFirstSubmap, 0.1);
  ASSERT_TRUE(before);
  map.factors().Place(frame, kFirstSubmap, *before);
  ASSERT_GT(Error(), 0.2) << "there is drift to take out";
  const Eigen::Vector3d landmark = map.Find(PointId(1000))->p_W;
  const auto report = Adjust(defaults);
  ASSERT_TRUE(report);
  ASSERT_TRUE(report->accepted) << report->message;
  EXPECT_EQ(report->keyframes, kKeyFrames);
  EXPECT_GT(report->moved, 0.2);
  // 50 positions of 0.1 m together are better than one of them.
  EXPECT_LT(Error(), 0.1);
  EXPECT_GT((map.Find(PointId(1000))->p_W - landmark).norm(), 0.01) << "landmarks follow";
  EXPECT_EQ(map.keyframe(0_kf)->T_WC.p(), ring.truth[0].p()) << "the origin holds the world";
}

// Wheels that measure the motion of each step exactly, with a noise stated such that the drift of
// one step is half a sigma: no single residual contradicts the drifted map, but their runs do.
TEST_F(FactorAdjusterTest, ARunOfMotionsShowsADriftThatNoneOfThemShows) {
  // A turn of 0.1 degrees a step to one side, and nothing else.
  const Pose drift = Pose::FromTangent({0, 0, 0}, {0, 0.1 * M_PI / 180.0, 0});
  Pose T = ring.truth.front();
  Eigen::Matrix<double, 6, 6> W = Eigen::Matrix<double, 6, 6>::Identity() / 0.05;
  W.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() / (0.2 * M_PI / 180.0);
  for (std::size_t i = 1; i < ring.truth.size(); ++i) {
    const Pose step = ring.truth[i - 1].Inverse() * ring.truth[i];
    T = T * step * drift;
    map.keyframe(KeyFrameId(i))->T_WC = T;
    map.AddFactor({{{KeyFrameId(i - 1), Pose()}, {KeyFrameId(i), Pose()}},
                   kNoId,
                   std::make_shared<RelativePose>(step, W),
                   nullptr,
                   "wheels"});
  }
  const auto turned = [&] {
    return (ring.truth.back().Inverse() * ring.map.keyframe(ring.last())->T_WC).Angle();
  };
  const double before = turned();
  ASSERT_GT(before, 0.3);
  const auto report = Adjust(defaults);
  ASSERT_TRUE(report && report->accepted);
  EXPECT_LT(turned(), 0.8 * before);
}

TEST_F(FactorAdjusterTest, FactorsOfOneSourceAndKindAreOneSeries) {
  map.factors().Place(frame, kFirstSubmap, kT_FW);
  const auto motion =
      std::make_shared<RelativePose>(Pose(), Eigen::Matrix<double, 6, 6>::Identity());
  const auto add = [&](int from, const char* source) {
    map.AddFactor({{{KeyFrameId(from), Pose()}, {KeyFrameId(from + 1), Pose()}},
                   kNoId,
                   motion,
                   nullptr,
                   source});
  };
  const auto measure = [&](int at, const char* source) {
    map.AddFactor(
        {{{KeyFrameId(at), Pose()}}, frame, PositionInFrame(kT_FW.p(), 1.0), nullptr, source});
  };
  add(0, "wheels");
  measure(0, "gps");
  add(1, "legs");
  add(2, "wheels");
  measure(2, "gps");
  measure(4, "total station");
  const KeyFrameGraph graph = MakeKeyFrameGraph(map, kModel, {});
  // The tilt of the frame comes before its first position.
  EXPECT_EQ(graph.series, (std::vector<std::size_t>{0, 1, 2, 3, 0, 2, 4}));
}

TEST_F(FactorAdjusterTest, InTheBackgroundItComesToTheSame) {
  Measure(0.1);
  const auto report = Adjust({}, 2);
  ASSERT_TRUE(report && report->accepted);
  EXPECT_LT(Error(), 0.1);
}

TEST_F(FactorAdjusterTest, KeepsGravityWhereTheMapKnowsIt) {
  Measure(0.1);
  ASSERT_TRUE(Adjust(defaults)->accepted);
  for (std::size_t i = 0; i < ring.truth.size(); ++i) {
    const Eigen::Vector3d up_C = ring.truth[i].R().transpose() * Eigen::Vector3d::UnitZ();
    // The graph leaves 1e-3 rad to each keyframe.
    EXPECT_LT((map.keyframe(KeyFrameId(i))->T_WC.q() * up_C - Eigen::Vector3d::UnitZ()).norm(),
              5e-3);
  }
}

TEST_F(FactorAdjusterTest, FindsTheFrameFromAnyHeadingOnceItIsObservable) {
  // The path is half a metre: 10 cm of noise leave the heading unobservable.
  Measure(0.1, 1, 2);
  EXPECT_FALSE(AlignFrame(map, frame, kFirstSubmap, 0.1));
  const auto report = Adjust(defaults);
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->accepted);
  EXPECT_NE(report->message.find("not known yet"), std::string::npos) << report->message;
  for (const double heading : {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0}) {
    Map other = map.Clone();
    const ReferenceFrameId turned = other.factors().AddFrame({});
    const Pose T_FW = Pose::FromTangent({10, 20, 30}, {0, 0, heading});
    for (int i = 0; i < kKeyFrames; i += 10) {
      const KeyFrameId id(i);
      other.AddFactor({{{id, Pose()}},
                       turned,
                       PositionInFrame(T_FW * other.keyframe(id)->T_WC.p(), 0.1),
                       nullptr});
    }
    const auto found = AlignFrame(other, turned, kFirstSubmap, 0.1);
    ASSERT_TRUE(found) << heading;
    EXPECT_LT((found->p() - T_FW.p()).norm(), 1e-4) << heading;
    EXPECT_LT((found->Inverse() * T_FW).Angle(), 1e-5) << heading;
  }
}

TEST_F(FactorAdjusterTest, AStraightPathRevealsTheHeadingOfAnUprightFrame) {
  Map straight;
  const auto features = std::make_shared<FrameFeatures>();
  const ReferenceFrameId upright = straight.factors().AddFrame({}),
                         any = straight.factors().AddFrame({.upright = false});
  const Pose T_FW = Pose::FromTangent({10, 20, 30}, {0, 0, 2.0});
  for (int i = 0; i < 20; ++i) {
    const Pose T_WC = Pose::FromTangent({0.5 * i, 0, 0}, {0, 0, 0});
    const KeyFrameId id = straight.AddKeyFrame({.index = i, .features = features}, T_WC).id;
    const auto cost = PositionInFrame(T_FW * T_WC.p(), 0.01);
    straight.AddFactor({{{id, Pose()}}, upright, cost, nullptr});
    straight.AddFactor({{{id, Pose()}}, any, cost, nullptr});
  }
  const auto found = AlignFrame(straight, upright, kFirstSubmap, 0.1);
  ASSERT_TRUE(found);
  EXPECT_LT((found->Inverse() * T_FW).Angle(), 1e-5);
  EXPECT_FALSE(AlignFrame(straight, any, kFirstSubmap, 0.1)) << "it may turn about the way";
}

TEST_F(FactorAdjusterTest, BeginsWhenEnoughFactorsAreNew) {
  UserFactorOptions options = defaults;
  options.every = 30;
  FactorAdjuster adjuster(kModel, options, {});
  Measure(0.1, 10);  // 20
  EXPECT_FALSE(adjuster.Begin(map, kFirstSubmap, {}));
  Measure(0.1, 10);
  EXPECT_TRUE(adjuster.Begin(map, kFirstSubmap, {}));
  EXPECT_FALSE(adjuster.Begin(map, kFirstSubmap, {})) << "one at a time";
  EXPECT_TRUE(adjuster.Finish(&map)->accepted);
  EXPECT_FALSE(adjuster.BeginLast(map, kFirstSubmap, {})) << "nothing is new";
  EXPECT_FALSE(adjuster.Finish(&map));
}

TEST_F(FactorAdjusterTest, NewFactorsAreNewWhereOthersHaveLeft) {
  FactorAdjuster adjuster(kModel, defaults, {}, 0);
  Measure(0.1);
  ASSERT_TRUE(adjuster.BeginLast(map, kFirstSubmap, {}));
  ASSERT_TRUE(adjuster.Finish(&map)->accepted);
  for (int i = 0; i < 5; ++i) map.factors().Remove(KeyFrameId(4 * i));
  EXPECT_FALSE(adjuster.BeginLast(map, kFirstSubmap, {}));
  Measure(0.1, 4, 8);  // three of five that have left
  EXPECT_TRUE(adjuster.BeginLast(map, kFirstSubmap, {}));
}

TEST_F(FactorAdjusterTest, RepeatsACancelledAdjustment) {
  Measure(0.1);
  FactorAdjuster adjuster(kModel, defaults, {});
  ASSERT_TRUE(adjuster.Begin(map, kFirstSubmap, {}));
  const Pose before = map.keyframe(150_kf)->T_WC;
  adjuster.Drop();
  EXPECT_FALSE(adjuster.Finish(&map));
  EXPECT_EQ(map.keyframe(150_kf)->T_WC.p(), before.p());
  EXPECT_TRUE(adjuster.Begin(map, kFirstSubmap, {}));
}

TEST_F(FactorAdjusterTest, AdjustsEachWorldByItself) {
  Measure(0.1);  // 50 positions of the first world
  const SubmapId other = map.AddSubmap();
  const auto features = std::make_shared<FrameFeatures>();
  for (int i = 0; i < 40; ++i) {
    const Pose T_WC = Pose::FromTangent({0.5 * i, 0, 0}, {0, 0, 0.1 * i});
    const KeyFrameId id =
        map.AddKeyFrame({.index = kKeyFrames + i, .features = features}, T_WC, other).id;
    map.AddFactor({{{id, Pose()}}, frame, PositionInFrame(kT_FW * T_WC.p(), 0.1), nullptr});
  }
  FactorAdjuster adjuster(kModel, defaults, {});
  ASSERT_TRUE(adjuster.Begin(map, kFirstSubmap, {}));
  ASSERT_TRUE(adjuster.Finish(&map)->accepted);
  ASSERT_TRUE(adjuster.Begin(map, other, {})) << "those of the first world are none of its own";
  ASSERT_TRUE(adjuster.Finish(&map)->accepted);
  EXPECT_TRUE(map.factors().T_FW(frame, other));
  EXPECT_FALSE(adjuster.BeginLast(map, kFirstSubmap, {}));
  EXPECT_FALSE(adjuster.BeginLast(map, other, {}));
}

// Older than the newest factor that has been adjusted, but of another world at that time.
TEST_F(FactorAdjusterTest, FactorsOfAWorldThatIsJoinedAreNewIfTheyWereNotAdjusted) {
  const SubmapId other = map.AddSubmap();
  const auto features = std::make_shared<FrameFeatures>();
  const KeyFrameId id =
      map.AddKeyFrame({.index = kKeyFrames, .features = features}, Pose(), other).id;
  map.AddFactor({{{id, Pose()}}, frame, PositionInFrame(kT_FW * Pose().p(), 0.1), nullptr});
  Measure(0.1);
  FactorAdjuster adjuster(kModel, defaults, {});
  ASSERT_TRUE(adjuster.BeginLast(map, kFirstSubmap, {}));
  ASSERT_TRUE(adjuster.Finish(&map)->accepted);
  ASSERT_FALSE(adjuster.BeginLast(map, kFirstSubmap, {}));
  map.Join(kFirstSubmap, other);
  EXPECT_TRUE(adjuster.BeginLast(map, kFirstSubmap, {}));
}

TEST_F(FactorAdjusterTest, FactorsOfALoadedMapAreNotNew) {
  Measure(0.1);
  FactorAdjuster adjuster(kModel, defaults, {});
  adjuster.Adopt(map);
  EXPECT_FALSE(adjuster.BeginLast(map, kFirstSubmap, {}));
  Measure(0.1, 10);
  EXPECT_TRUE(adjuster.Begin(map, kFirstSubmap, {}));
  EXPECT_EQ(adjuster.Finish(&map)->factors, 50 + 20 + 1) << "all take part, and the frame's tilt";
}

// A cost whose evaluation blocks until it is opened; once, for ten seconds at most.
class GatedCost final : public ceres::SizedCostFunction<3, 7, 7> {
 public:
  explicit GatedCost(std::shared_ptr<ceres::CostFunction> cost) : cost_(std::move(cost)) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    std::unique_lock lock(mutex_);
    entered_ = true;
    changed_.notify_all();
    if (!changed_.wait_for(lock, std::chrono::seconds(10), [&] { return open_; })) open_ = true;
    return cost_->Evaluate(parameters, residuals, jacobians);
  }
  void WaitUntilEntered() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return entered_; });
  }
  // Returns false if it has opened by its timeout.
  bool Open() {
    const std::lock_guard lock(mutex_);
    const bool was_shut = !std::exchange(open_, true);
    changed_.notify_all();
    return was_shut;
  }

 private:
  const std::shared_ptr<ceres::CostFunction> cost_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  mutable bool entered_ = false, open_ = false;
};

TEST_F(FactorAdjusterTest, WhoCancelsDoesNotWait) {
  Measure(0.1);
  const auto gate = std::make_shared<GatedCost>(PositionInFrame(kT_FW * ring.truth[0].p(), 0.1));
  map.AddFactor({{{0_kf, Pose()}}, frame, gate, nullptr});
  FactorAdjuster adjuster(kModel, {}, {}, 1);
  ASSERT_TRUE(adjuster.Begin(map, kFirstSubmap, {}));
  gate->WaitUntilEntered();
  adjuster.Drop();
  EXPECT_TRUE(gate->Open()) << "it was waited for";
  EXPECT_FALSE(adjuster.Finish(&map));
  ASSERT_TRUE(adjuster.Begin(map, kFirstSubmap, {}));
  EXPECT_TRUE(adjuster.Finish(&map)->accepted);
}

TEST_F(FactorAdjusterTest, DoesNotFitAgainWhatTheGraphOfALoopFitted) {
  Measure(0.5, 1);
  const LoopEdge loop = ring.Loop(0_kf, ring.last());
  Map at_once = map.Clone();
  FactorAdjuster fresh(kModel, defaults, {}), adjuster(kModel, defaults, {});
  ASSERT_TRUE(fresh.BeginLast(at_once, kFirstSubmap, {&loop, 1}));
  ASSERT_TRUE(fresh.Finish(&at_once)->accepted);

  ASSERT_TRUE(adjuster.BeginLast(map, kFirstSubmap, {}));
  ASSERT_TRUE(adjuster.Finish(&map)->accepted);
  const LoopCorrectionResult closed = CorrectLoop({}, {.edge = loop}, kModel, {}, {}, &map);
  ASSERT_TRUE(closed.accepted) << closed.message;
  adjuster.Remember(map, closed.by_factors);
  // One additional factor with no information.
  map.AddFactor({{{0_kf, Pose()}}, frame, PositionInFrame({0, 0, 0}, 1e9), nullptr});
  ASSERT_TRUE(adjuster.BeginLast(map, kFirstSubmap, {&loop, 1}));
  ASSERT_TRUE(adjuster.Finish(&map)->accepted);
  double farthest = 0.0;
  for (const KeyFrameId id : map.keyframe_ids()) {
    const Eigen::Vector3d off = map.keyframe(id)->T_WC.p() - at_once.keyframe(id)->T_WC.p();
    farthest = std::max(farthest, off.norm());
  }
  EXPECT_LT(farthest, 0.01);
}

TEST_F(FactorAdjusterTest, ALoopIsClosedWithThemAndTheirFrame) {
  Measure(0.1);
  map.factors().Place(frame, kFirstSubmap, *AlignFrame(map, frame, kFirstSubmap, 0.1));
  const KeyFrameGraph graph = MakeKeyFrameGraph(map, kModel, {});
  EXPECT_EQ(graph.frames.size(), 1u);
  EXPECT_EQ(graph.graph.factors.size(), 51u);  // plus the factor of the frame's tilt
  // A loop is judged by the drift that remains with these factors.
  const LoopEdge loop = ring.Loop(0_kf, ring.last());
  const double with = *LoopChi2(graph, loop);
  map.factors() = {};
  const double without = *LoopChi2(MakeKeyFrameGraph(map, kModel, {}), loop);
  EXPECT_GT(with, 10.0 * without);
}

// A map of a drive of 2 km at 2 m/s, with one fix per second.
TEST(FactorAdjuster, TwoKilometresWithAFixASecondEndWithoutDrift) {
  RingMap ring(8000);
  ring.Drift({.bias_rotation = 0.003 * M_PI / 180.0}, /*levelled=*/true);
  const ReferenceFrameId frame = ring.map.factors().AddFrame({});
  std::mt19937 rng(8);
  std::normal_distribution<double> normal(0.0, 0.5);
  const auto errors_in = [&](const Pose& T_FW) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < ring.truth.size(); ++i) {
      const Pose& T_WC = ring.map.keyframe(KeyFrameId(i))->T_WC;
      errors.push_back((T_FW * T_WC.p() - kT_FW * ring.truth[i].p()).norm());
    }
    return errors;
  };
  FactorAdjuster adjuster(kModel, {}, {}, 0);
  for (std::size_t i = 0; i < ring.truth.size(); i += 8) {
    const double x = normal(rng), y = normal(rng), z = normal(rng);
    const Eigen::Vector3d p_F = kT_FW * ring.truth[i].p() + Eigen::Vector3d(x, y, 2.0 * z);
    ring.map.AddFactor({{{KeyFrameId(i), Pose()}}, frame, PositionInFrame(p_F, 0.6), nullptr});
  }
  const std::optional<Pose> before = AlignFrame(ring.map, frame, kFirstSubmap, 0.1);
  ASSERT_TRUE(before);
  const std::vector<double> drift = errors_in(*before);
  EXPECT_GT(*std::max_element(drift.begin(), drift.end()), 5.0) << "there is drift to take out";
  ASSERT_TRUE(adjuster.BeginLast(ring.map, kFirstSubmap, {}));
  ASSERT_TRUE(adjuster.Finish(&ring.map)->accepted);
  const std::vector<double> left = errors_in(*ring.map.factors().T_FW(frame, kFirstSubmap));
  double sum = 0.0;
  for (const double error : left) sum += error * error;
  EXPECT_LT(std::sqrt(sum / static_cast<double>(left.size())), 0.5);
  EXPECT_LT(*std::max_element(left.begin(), left.end()), 1.0);
}

TEST(UserFactorOptions, AreValidated) {
  EXPECT_NO_THROW(UserFactorOptions().Validate());
  EXPECT_THROW(UserFactorOptions{.every = 0}.Validate(), InvalidArgument);
  EXPECT_THROW(UserFactorOptions{.share = -1.0}.Validate(), InvalidArgument);
  EXPECT_THROW(UserFactorOptions{.max_angle = 0.0}.Validate(), InvalidArgument);
  EXPECT_THROW(UserFactorOptions{.max_gap = 0.0}.Validate(), InvalidArgument);
}

// An invalid user cost: it throws, refuses, or is not finite.
enum class Fault { kThrows, kThrowsANumber, kRefuses, kNotFinite };
class Faulty final : public ceres::SizedCostFunction<3, 7, 7> {
 public:
  explicit Faulty(Fault fault) : fault_(fault) {}
  bool Evaluate(double const* const*, double* r, double**) const override {
    if (fault_ == Fault::kThrows) throw std::runtime_error("the marker was not found");
    if (fault_ == Fault::kThrowsANumber) throw 7;
    std::fill_n(r, 3, std::numeric_limits<double>::quiet_NaN());
    return fault_ != Fault::kRefuses;
  }

 private:
  Fault fault_;
};

TEST_F(FactorAdjusterTest, RejectsOneFaultyFactorOfSevenAndPlacesTheFrameByTheOthers) {
  Measure(0.1);
  const int faulty = static_cast<int>(map.factors().all().size()) / 6;
  constexpr Fault kFaults[] = {Fault::kThrows, Fault::kThrowsANumber, Fault::kRefuses,
                               Fault::kNotFinite};
  for (int i = 0; i < faulty; ++i) {
    auto cost = std::make_shared<Faulty>(kFaults[i % 4]);
    map.AddFactor({{{KeyFrameId(8 * i), Pose()}}, frame, std::move(cost), nullptr});
  }
  std::optional<FactorAdjustmentReport> report;
  ASSERT_NO_THROW(report = Adjust(defaults));
  ASSERT_TRUE(report && report->accepted) << report->message;
  EXPECT_EQ(report->excluded, faulty);
  EXPECT_EQ(report->fault, "throws: the marker was not found");
  EXPECT_LT(Error(), 0.1);
}

}  // namespace
}  // namespace highwall::factor_adjuster_test
