#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>
#include <highwall/core/testing/jacobian_check.h>
#include <highwall/frontend/local/bundle_adjustment.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/user_factors.h>

#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include "map/anchored_cost.h"
#include "support/id_literals.h"
#include "support/position_in_frame.h"
#include "support/synthetic_scene.h"
#include "system/pending_factors.h"

namespace highwall::user_factors_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::PositionInFrame;
using testing::Scene;
using testing::SceneMap;
using testing::operator""_kf;

constexpr SubmapId kSecondSubmap{1};
const PoseManifold kManifold;

Pose RandomPose(std::mt19937& rng) {
  const auto vector = [&rng] { return testing::UniformInBox(rng, {-1, -1, -1}, {1, 1, 1}); };
  const Eigen::Vector3d p = vector();
  return Pose::FromTangent(p, vector());
}

std::vector<double> ToBlock(const Pose& pose) {
  return {pose.data(), pose.data() + Pose::kSize};
}

Eigen::VectorXd Residual(const ceres::CostFunction& cost, const std::vector<Pose>& poses) {
  std::vector<const double*> blocks;
  for (const Pose& pose : poses) blocks.push_back(pose.data());
  Eigen::VectorXd r(cost.num_residuals());
  EXPECT_TRUE(cost.Evaluate(blocks.data(), r.data(), nullptr));
  return r;
}

// Four views of a scene, three of them in the first submap.
class UserFactorsTest : public ::testing::Test {
 protected:
  UserFactorsTest() : scene(MakeScene(9, 120, 30)), scene_map(scene) {
    for (const Pose& T_WC : truth) scene_map.Add(Look(scene, IdealSensor(), T_WC), T_WC);
    frame = map.factors().AddFrame({});
  }

  MapFactor At(KeyFrameId keyframe, const Pose& T_KB = Pose()) const {
    return {{{keyframe, T_KB}}, frame, PositionInFrame(Eigen::Vector3d(1, 2, 3), 0.1), nullptr};
  }
  const AnchoredBodyPose& OnlyPose() const { return map.factors().all().at(0).poses.at(0); }

  const std::vector<Pose> truth{Pose::FromTangent({0, 0, 0}, {0, 0, 0}),
                                Pose::FromTangent({0.3, 0, 0}, {0, -0.05, 0.02}),
                                Pose::FromTangent({0.3, 0.3, 0.1}, {0.05, -0.05, 0}),
                                Pose::FromTangent({-0.2, 0.2, 0.1}, {0.02, 0.05, 0})};
  const MeasurementModel model{IdealSensor(), {}};
  const Scene scene;
  SceneMap scene_map;
  Map& map = scene_map.map;
  ReferenceFrameId frame;
};

TEST_F(UserFactorsTest, APoseKeepsItsPlaceWhenItsKeyFrameIsCulled) {
  const Pose T_KB = Pose::FromTangent({0.1, 0.2, 0.3}, {0.3, 0.2, 0.1});
  ASSERT_TRUE(map.AddFactor(At(2_kf, T_KB)));
  map.RemoveKeyFrame(2_kf, 1_kf);
  EXPECT_EQ(OnlyPose().keyframe, 1_kf);
  EXPECT_LT((truth[1] * OnlyPose().T_KB.p() - truth[2] * T_KB.p()).norm(), 1e-12);
  EXPECT_LT(((truth[1] * OnlyPose().T_KB).Inverse() * (truth[2] * T_KB)).Angle(), 1e-7);
}

TEST_F(UserFactorsTest, AFactorOfACulledKeyFrameIsAnchoredToItsParent) {
  map.RemoveKeyFrame(2_kf, 1_kf);
  map.RemoveKeyFrame(1_kf, 0_kf);
  ASSERT_TRUE(map.AddFactor(At(2_kf)));
  EXPECT_EQ(OnlyPose().keyframe, 0_kf);
  EXPECT_LT((OnlyPose().T_KB.p() - truth[2].p()).norm(), 1e-12);
}

TEST_F(UserFactorsTest, AMotionWithinOneKeyFrameIsDroppedAndCounted) {
  const auto motion =
      std::make_shared<RelativePose>(Pose(), Eigen::Matrix<double, 6, 6>::Identity());
  const auto between = [&](KeyFrameId a, KeyFrameId b, const char* source) {
    return map.AddFactor({{{a, Pose()}, {b, truth[1]}}, kNoId, motion, nullptr, source});
  };
  EXPECT_TRUE(between(1_kf, 1_kf, "wheels"));
  EXPECT_TRUE(map.factors().all().empty());
  EXPECT_TRUE(between(1_kf, 2_kf, "wheels"));
  EXPECT_TRUE(between(0_kf, 2_kf, "legs"));
  ASSERT_TRUE(map.AddFactor(At(2_kf)));
  EXPECT_EQ(map.factors().all().size(), 3u);
  EXPECT_EQ(map.factors().dropped().at("wheels"), 1u);
  map.RemoveKeyFrame(2_kf, 1_kf);  // both ends of a motion are at 1_kf now
  EXPECT_EQ(map.factors().all().size(), 2u) << "a position stays";
  EXPECT_EQ(map.factors().dropped().at("wheels"), 2u);
  EXPECT_FALSE(map.factors().dropped().contains("legs"));
  map.RemoveKeyFrame(1_kf, 0_kf);
  EXPECT_EQ(map.factors().all().size(), 1u);
  EXPECT_EQ(map.factors().dropped().at("legs"), 1u);
}

TEST_F(UserFactorsTest, FactorsAnchoredToASubmapAreDroppedWithIt) {
  const SubmapId submap = map.AddSubmap();
  const KeyFrameId other = map.AddKeyFrame(map.keyframe(3_kf)->frame, Pose(), submap).id;
  ASSERT_TRUE(map.AddFactor(At(0_kf)));
  ASSERT_TRUE(map.AddFactor(At(other)));
  map.RemoveSubmap(submap);
  ASSERT_EQ(map.factors().all().size(), 1u);
  EXPECT_EQ(OnlyPose().keyframe, 0_kf);
  EXPECT_FALSE(map.AddFactor(At(other)));
}

TEST_F(UserFactorsTest, AFrameStaysWhereItIsWhenTheWorldMoves) {
  std::mt19937 rng(3);
  const Pose T_FW = RandomPose(rng), T_new_old = RandomPose(rng);
  map.factors().Place(frame, kFirstSubmap, T_FW);
  const Eigen::Vector3d p_F = T_FW * map.keyframe(3_kf)->T_WC.p();
  map.Transform(T_new_old);
  EXPECT_LT((*map.factors().T_FW(frame, kFirstSubmap) * map.keyframe(3_kf)->T_WC.p() - p_F).norm(),
            1e-12);
  map.Transform(T_new_old, kFirstSubmap);
  EXPECT_LT((*map.factors().T_FW(frame, kFirstSubmap) * map.keyframe(3_kf)->T_WC.p() - p_F).norm(),
            1e-12);
}

TEST_F(UserFactorsTest, AMergeKeepsAFrameThatEitherWorldKnew) {
  std::mt19937 rng(4);
  const Pose of_second = RandomPose(rng), of_first = RandomPose(rng);
  const SubmapId submap = map.AddSubmap();
  map.factors().Place(frame, submap, of_second);
  EXPECT_FALSE(map.factors().T_FW(frame, kFirstSubmap));
  map.Join(kFirstSubmap, submap);
  EXPECT_LT((map.factors().T_FW(frame, kFirstSubmap)->p() - of_second.p()).norm(), 1e-15);
  const SubmapId third = map.AddSubmap();
  map.factors().Place(frame, third, of_first);
  map.Join(kFirstSubmap, third);
  EXPECT_LT((map.factors().T_FW(frame, kFirstSubmap)->p() - of_second.p()).norm(), 1e-15);
}

TEST_F(UserFactorsTest, AFactorHasNoEffectUntilItsFrameIsKnown) {
  ASSERT_TRUE(map.AddFactor(At(1_kf)));
  EXPECT_TRUE(FactorsIn(map, kFirstSubmap).empty());
  map.factors().Place(frame, kFirstSubmap, Pose());
  EXPECT_EQ(FactorsIn(map, kFirstSubmap).size(), 1u);
}

TEST_F(UserFactorsTest, APoseInNoFrameIsOneOfTheFirstWorldAndAMotionOfAny) {
  const SubmapId submap = map.AddSubmap();
  ASSERT_EQ(submap, kSecondSubmap);
  const KeyFrameId a = map.AddKeyFrame(map.keyframe(3_kf)->frame, Pose(), submap).id;
  const KeyFrameId b = map.AddKeyFrame(map.keyframe(3_kf)->frame, Pose(), submap).id;
  const auto one = std::make_shared<PosePrior>(Pose(), Eigen::Matrix<double, 6, 6>::Identity());
  const auto two = std::make_shared<RelativePose>(Pose(), Eigen::Matrix<double, 6, 6>::Identity());
  map.AddFactor({{{a, Pose()}}, kNoId, one, nullptr});
  map.AddFactor({{{0_kf, Pose()}}, kNoId, one, nullptr});
  map.AddFactor({{{a, Pose()}, {b, Pose()}}, kNoId, two, nullptr});
  map.AddFactor({{{0_kf, Pose()}, {a, Pose()}}, kNoId, two, nullptr});  // between two worlds
  EXPECT_EQ(FactorsIn(map, kFirstSubmap).size(), 1u);
  EXPECT_EQ(FactorsIn(map, submap).size(), 1u);
  map.Join(kFirstSubmap, submap);
  EXPECT_EQ(FactorsIn(map, kFirstSubmap).size(), 4u);
}

TEST_F(UserFactorsTest, PullsAKeyFrameInAnAdjustment) {
  // The factors measure the truth in a frame that is 10 m away; the last keyframe is 5 cm off, and
  // few landmarks constrain it.
  const Pose T_FW = Pose::FromTangent({10, -4, 2}, {0, 0, 1.0});
  map.factors().Place(frame, kFirstSubmap, T_FW);
  const Eigen::Vector3d off(0.05, 0, 0);
  for (const PointId id : map.ids<MapPoint>()) map.Remove(id);
  for (const LineId id : map.ids<MapLine>()) map.Remove(id);
  map.keyframe(3_kf)->T_WC = Pose(truth[3].q(), truth[3].p() + off);
  map.AddFactor({{{3_kf, Pose()}}, frame, PositionInFrame(T_FW * truth[3].p(), 0.01), nullptr});
  const std::vector<KeyFrameId> free{3_kf}, fixed{0_kf, 1_kf, 2_kf};
  const BundleAdjustmentReport report = AdjustBundle(map, model, free, fixed);
  ASSERT_TRUE(report.usable);
  EXPECT_EQ(report.user_factors, 1);
  EXPECT_LT((map.keyframe(3_kf)->T_WC.p() - truth[3].p()).norm(), 1e-6);
  // A frame with factors of few keyframes stays fixed.
  EXPECT_EQ(map.factors().T_FW(frame, kFirstSubmap)->p(), T_FW.p());
}

// A cost that can be evaluated a given number of times, and throws afterwards.
class WearsOut final : public ceres::SizedCostFunction<3, 7, 7> {
 public:
  explicit WearsOut(int times) : left_(times) {}
  bool Evaluate(double const* const*, double* r, double** J) const override {
    if (left_-- <= 0) throw std::runtime_error("worn out");
    std::fill_n(r, 3, 1.0);
    for (int i = 0; J != nullptr && i < 2; ++i) {
      if (J[i] != nullptr) std::fill_n(J[i], 21, 0.0);
    }
    return true;
  }

 private:
  mutable int left_;
};

TEST_F(UserFactorsTest, RejectsAFactorThatThrowsAndAdjustsTheMap) {
  map.factors().Place(frame, kFirstSubmap, Pose());
  const std::vector<KeyFrameId> free{3_kf}, fixed{0_kf, 1_kf, 2_kf};
  for (const int times : {0, 4}) {  // immediately, and during the solution
    map.keyframe(3_kf)->T_WC = Pose(truth[3].q(), truth[3].p() + Eigen::Vector3d(0.005, 0, 0));
    map.AddFactor({{{3_kf, Pose()}}, frame, std::make_shared<WearsOut>(times), nullptr});
    BundleAdjustmentReport report;
    ASSERT_NO_THROW(report = AdjustBundle(map, model, free, fixed, {.first_iterations = 20}));
    ASSERT_TRUE(report.usable) << report.message;
    EXPECT_EQ(report.user_factors, 0);
    EXPECT_EQ(report.user_factors_excluded, times == 0 ? 1 : 2);
    EXPECT_LT((map.keyframe(3_kf)->T_WC.p() - truth[3].p()).norm(), 1e-4);
  }
}

// A cost that throws only in a solver's trial steps, which are without Jacobians.
class ThrowsAtTrials final : public ceres::SizedCostFunction<3, 7, 7> {
 public:
  bool Evaluate(double const* const*, double* r, double** J) const override {
    if (J == nullptr) throw std::runtime_error("a trial");
    std::fill_n(r, 3, 1.0);
    for (int i = 0; i < 2; ++i) {
      if (J[i] != nullptr) std::fill_n(J[i], 21, 0.0);
    }
    return true;
  }
};

TEST_F(UserFactorsTest, RejectsTwoFactorsThatFailInDifferentWaysTogether) {
  map.factors().Place(frame, kFirstSubmap, Pose());
  const std::vector<KeyFrameId> free{3_kf}, fixed{0_kf, 1_kf, 2_kf};
  map.keyframe(3_kf)->T_WC = Pose(truth[3].q(), truth[3].p() + Eigen::Vector3d(0.005, 0, 0));
  map.AddFactor({{{3_kf, Pose()}}, frame, std::make_shared<ThrowsAtTrials>(), nullptr});
  for (const int times : {4, 8}) {
    map.AddFactor({{{3_kf, Pose()}}, frame, std::make_shared<WearsOut>(times), nullptr});
  }
  BundleAdjustmentReport report;
  ASSERT_NO_THROW(report = AdjustBundle(map, model, free, fixed, {.first_iterations = 20}));
  ASSERT_TRUE(report.usable) << report.message;
  EXPECT_TRUE(report.moved);
  EXPECT_EQ(report.user_factors_excluded, 3);
  EXPECT_LT((map.keyframe(3_kf)->T_WC.p() - truth[3].p()).norm(), 1e-4);
}

TEST_F(UserFactorsTest, AFrameMovesWhereEverythingIsAdjusted) {
  const Pose T_FW = Pose::FromTangent({10, -4, 2}, {0, 0, 1.0});
  map.factors().Place(frame, kFirstSubmap, T_FW * Pose::FromTangent({0.1, 0, 0}, {0, 0, 0.05}));
  for (const KeyFrameId id : map.keyframe_ids()) {
    map.AddFactor(
        {{{id, Pose()}}, frame, PositionInFrame(T_FW * truth[id.index()].p(), 0.01), nullptr});
  }
  const BundleAdjustmentReport report =
      AdjustBundle(map, model, map.keyframe_ids(), {}, {.first_iterations = 20});
  ASSERT_TRUE(report.usable);
  EXPECT_EQ(report.user_factors, 3);  // the factor of the fixed keyframe only constrains the frame
  // Three positions form a triangle of 0.5 m, and landmarks constrain the keyframes to 1e-6 m.
  EXPECT_LT((map.factors().T_FW(frame, kFirstSubmap)->p() - T_FW.p()).norm(), 1e-3);
  EXPECT_LT((map.factors().T_FW(frame, kFirstSubmap)->Inverse() * T_FW).Angle(), 1e-2);
}

TEST(AnchoredCost, IsTheCostOfTheBodiesThatKeyFramesCarry) {
  std::mt19937 rng(5);
  const Pose T_XC = RandomPose(rng), a = RandomPose(rng), b = RandomPose(rng);
  const Pose T_WX = RandomPose(rng), T_WY = RandomPose(rng);
  const auto relative =
      std::make_shared<RelativePose>(RandomPose(rng), Eigen::Matrix<double, 6, 6>::Identity());
  const MapFactor apart{{{4_kf, a}, {7_kf, b}}, kNoId, relative, nullptr};
  const AnchoredCost two(apart, T_XC);
  EXPECT_EQ(two.keyframes(), (std::vector<KeyFrameId>{4_kf, 7_kf}));
  EXPECT_LT((Residual(two, {T_WX, T_WY}) - Residual(*relative, {T_WX * T_XC * a, T_WY * T_XC * b}))
                .norm(),
            1e-12);
  const MapFactor together{{{4_kf, a}, {4_kf, b}}, kNoId, relative, nullptr};
  const AnchoredCost one(together, T_XC);
  EXPECT_EQ(one.keyframes(), std::vector<KeyFrameId>{4_kf});
  EXPECT_LT(
      (Residual(one, {T_WX}) - Residual(*relative, {T_WX * T_XC * a, T_WX * T_XC * b})).norm(),
      1e-12);
}

TEST(AnchoredCost, JacobiansMatchCentralDifferences) {
  std::mt19937 rng(6);
  for (int i = 0; i < 20; ++i) {
    SCOPED_TRACE(i);
    const Pose T_XC = RandomPose(rng), a = RandomPose(rng), b = RandomPose(rng);
    const std::vector<double> X = ToBlock(RandomPose(rng)), Y = ToBlock(RandomPose(rng));
    const AnchoredCost position(
        {{{4_kf, a}}, ReferenceFrameId(0), PositionInFrame({1, 2, 3}, 0.1), nullptr}, T_XC);
    auto check = testing::CheckJacobians(position, {X, Y}, {&kManifold, &kManifold});
    EXPECT_TRUE(check) << check.message;
    const auto relative =
        std::make_shared<RelativePose>(RandomPose(rng), Eigen::Matrix<double, 6, 6>::Identity());
    const AnchoredCost apart({{{4_kf, a}, {7_kf, b}}, kNoId, relative, nullptr}, T_XC);
    check = testing::CheckJacobians(apart, {X, Y}, {&kManifold, &kManifold});
    EXPECT_TRUE(check) << check.message;
  }
  // A body height, measured twice from one keyframe: both bodies' Jacobians add up in its block.
  const auto prior = std::make_shared<RelativePose>(Pose::FromTangent({0, 0, 1}, {0.1, 0, 0}),
                                                    Eigen::Matrix<double, 6, 6>::Identity());
  const AnchoredCost together(
      {{{4_kf, RandomPose(rng)}, {4_kf, RandomPose(rng)}}, kNoId, prior, nullptr}, Pose());
  const auto check = testing::CheckJacobians(together, {ToBlock(RandomPose(rng))}, {&kManifold});
  EXPECT_TRUE(check) << check.message;
}

TEST(PoseFactor, RefusesMismatchedCosts) {
  const auto cost = PositionInFrame({1, 2, 3}, 0.1);
  EXPECT_NO_THROW((PoseFactor{{7}, ReferenceFrameId(0), cost}.Validate()));
  EXPECT_THROW((PoseFactor{{7}, ReferenceFrameId(0), nullptr}.Validate()), InvalidArgument);
  EXPECT_THROW((PoseFactor{{}, ReferenceFrameId(0), cost}.Validate()), InvalidArgument);
  EXPECT_THROW((PoseFactor{{7}, kNoId, cost}.Validate()), InvalidArgument);
  EXPECT_THROW((PoseFactor{{7, 7}, kNoId, cost}.Validate()), InvalidArgument);
  EXPECT_THROW((PoseFactor{{8, 7}, kNoId, cost}.Validate()), InvalidArgument);
  EXPECT_NO_THROW((PoseFactor{{7, 8}, kNoId, cost}.Validate()));
}

// Frames at whole seconds, along x at 1 m/s.
class PendingFactorsTest : public UserFactorsTest {
 protected:
  void Frame(int second, KeyFrameId reference, double x) {
    frames.push_back({FromSeconds(second),
                      AnchoredPose::At(map, reference, Pose::FromTangent({x, 0, 0}, {0, 0, 0}))});
    pending.Attach(frames, &map);
  }
  void Add(std::vector<Stamp> stamps, std::string source = {}) {
    pending.Add(
        {std::move(stamps), frame, PositionInFrame({1, 2, 3}, 0.1), nullptr, std::move(source)});
  }
  Eigen::Vector3d Position(std::size_t factor) const {
    const AnchoredBodyPose& pose = map.factors().all().at(factor).poses.at(0);
    return map.keyframe(pose.keyframe)->T_WC * pose.T_KB.p();
  }

  PendingFactors pending{Pose::FromTangent({0, 0, 0.5}, {0, 0, 0}), 1.5};
  std::vector<PosedFrame> frames;
};

TEST_F(PendingFactorsTest, WaitForAFrameAndLieBetweenThoseAroundThem) {
  Frame(1, 0_kf, 1.0);
  Add({FromSeconds(1.25)});
  Add({FromSeconds(1.0)});
  pending.Attach(frames, &map);
  EXPECT_EQ(pending.Counts(map.factors()).waiting, 1u);
  ASSERT_EQ(pending.Counts(map.factors()).attached, 1u);
  EXPECT_LT((Position(0) - Eigen::Vector3d(1.0, 0, 0.5)).norm(), 1e-12);
  Frame(2, 3_kf, 2.0);
  EXPECT_EQ(pending.Counts(map.factors()).waiting, 0u);
  ASSERT_EQ(pending.Counts(map.factors()).attached, 2u);
  EXPECT_LT((Position(1) - Eigen::Vector3d(1.25, 0, 0.5)).norm(), 1e-12);
  EXPECT_EQ(map.factors().all()[1].poses[0].keyframe, 0_kf);  // of the nearer frame
}

TEST_F(PendingFactorsTest, AreRefusedBeforeTheFirstFrameInGapsAndBetweenWorlds) {
  const SubmapId submap = map.AddSubmap();
  const KeyFrameId other = map.AddKeyFrame(map.keyframe(3_kf)->frame, Pose(), submap).id;
  for (const double second : {0.5, 1.5, 3.0, 4.5}) Add({FromSeconds(second)});
  Frame(1, 0_kf, 1.0);
  EXPECT_EQ(pending.Counts(map.factors()).refused, 1u);  // it precedes the first frame
  Frame(2, 0_kf, 2.0);
  EXPECT_EQ(pending.Counts(map.factors()).attached, 1u);
  Frame(4, 0_kf, 4.0);
  EXPECT_EQ(pending.Counts(map.factors()).refused, 2u);  // 2 s apart
  Frame(5, other, 5.0);
  EXPECT_EQ(pending.Counts(map.factors()).refused, 3u);  // another world frame
  EXPECT_EQ(pending.Counts(map.factors()).waiting, 0u);
  EXPECT_EQ(map.factors().all().size(), 1u);
}

TEST_F(PendingFactorsTest, AMotionWithinOneKeyFrameCountsAsDropped) {
  const auto motion =
      std::make_shared<RelativePose>(Pose(), Eigen::Matrix<double, 6, 6>::Identity());
  pending.Add({{FromSeconds(1), FromSeconds(2)}, kNoId, motion, nullptr, "wheels"});
  pending.Add({{FromSeconds(1), FromSeconds(3)}, kNoId, motion, nullptr, "wheels"});
  Frame(1, 0_kf, 1.0);
  Frame(2, 0_kf, 2.0);
  Frame(3, 1_kf, 3.0);
  const FactorCounts counts = pending.BySource(map.factors()).at("wheels");
  EXPECT_EQ(counts.attached, 2u);
  EXPECT_EQ(counts.dropped, 1u);
  EXPECT_EQ(counts.refused, 0u);
  EXPECT_EQ(map.factors().all().size(), 1u);
}

TEST_F(PendingFactorsTest, AreCountedBySource) {
  // The stamps of the wheels are those of another clock.
  for (const double second : {1.0, 1.5, 5.0}) Add({FromSeconds(second)}, "gps");
  for (const double second : {-9.0, -8.0}) Add({FromSeconds(second)}, "wheels");
  Frame(1, 0_kf, 1.0);
  Frame(2, 0_kf, 2.0);
  const std::map<std::string, FactorCounts> counts = pending.BySource(map.factors());
  ASSERT_EQ(counts.size(), 2u);
  EXPECT_EQ(counts.at("gps").waiting, 1u);
  EXPECT_EQ(counts.at("gps").attached, 2u);
  EXPECT_EQ(counts.at("gps").refused, 0u);
  EXPECT_EQ(counts.at("wheels").waiting, 0u);
  EXPECT_EQ(counts.at("wheels").attached, 0u);
  EXPECT_EQ(counts.at("wheels").refused, 2u);
  EXPECT_EQ(map.factors().all()[0].source, "gps");
  const FactorCounts all = pending.Counts(map.factors());
  EXPECT_EQ(all.waiting, 1u);
  EXPECT_EQ(all.attached, 2u);
  EXPECT_EQ(all.refused, 2u);
}

}  // namespace
}  // namespace highwall::user_factors_test
