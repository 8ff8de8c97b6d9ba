#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/relative_pose.h>

#include "loops/loop_closer.h"
#include "support/loop_scene.h"

namespace highwall::loop_closer_test {
namespace {

using testing::LoopScene;
using testing::LoopSceneOptions;

const LoopSceneOptions kDrifting{.drift = {0.01, 0.005, 0.0}};

std::vector<LoopReport> Walk(LoopScene& scene, const LoopCloserOptions& options) {
  LoopCloser closer(scene.model, options, 0);
  std::vector<LoopReport> reports;
  const auto keep = [&](std::vector<LoopReport> more) {
    for (LoopReport& report : more) reports.push_back(std::move(report));
  };
  for (int i = 0; i < scene.size(); ++i) {
    const KeyFrameId id = scene.Add(i);
    closer.InsertKeyFrame(scene.map, id);
    keep(closer.Update(&scene.map));
  }
  keep(closer.Finish(&scene.map));
  return reports;
}

double DriftedRmse() {
  LoopScene scene(kDrifting);
  for (int i = 0; i < scene.size(); ++i) scene.Add(i);
  return scene.Rmse();
}

TEST(LoopCloser, TakesTheDriftOutOfTheLoop) {
  LoopScene scene(kDrifting);
  const auto reports = Walk(scene, {});
  ASSERT_GE(reports.size(), 2u);
  EXPECT_TRUE(reports[0].accepted) << reports[0].message;
  EXPECT_FALSE(reports[0].bundle);
  EXPECT_GT(reports[0].fused_points, 50);
  EXPECT_GT(reports[0].fused_lines, 3);
  ASSERT_TRUE(reports[1].bundle);
  EXPECT_TRUE(reports[1].bundle->usable);
  // The keyframes after the loop continue to drift.
  EXPECT_LT(scene.Rmse(), 0.25 * DriftedRmse());
}

TEST(LoopCloser, LinesPassTheOutlierRuleOfTheModel) {
  LoopSceneOptions options = kDrifting;
  options.measurement = testing::kStrictRule;
  options.matching = testing::kStrictLines;
  LoopScene scene(options);
  const auto reports = Walk(scene, {});
  ASSERT_FALSE(reports.empty());
  EXPECT_TRUE(reports[0].accepted) << reports[0].message;
  EXPECT_LE(reports[0].fused_lines, 2);
}

TEST(LoopCloser, TheFewStepsOfTheAdjustmentReachTheBottomForALongLoop) {
  LoopScene scene({.per_lap = 320, .points = 4000, .lines = 100, .drift = {0.001, 0.0003, 0.0}});
  LoopCloser closer(scene.model, {}, 0);
  std::vector<LoopReport> reports;
  for (int i = 0; i < scene.size() && reports.empty(); ++i) {
    closer.InsertKeyFrame(scene.map, scene.Add(i));
    reports = closer.Update(&scene.map);
  }
  ASSERT_EQ(reports.size(), 2u);
  ASSERT_TRUE(reports[1].bundle);
  const MapGeometry few = GeometryOf(scene.map);
  constexpr double kAll = 1e9;  // no outliers: the same problem
  const BundleAdjustmentOptions on{.inliers = {.chi2_2 = kAll, .chi2_3 = kAll, .chi2_4 = kAll},
                                   .first_iterations = 30,
                                   .second_iterations = 30,
                                   .tolerance = 0.0};
  AdjustBundle(scene.map, scene.model, scene.map.keyframe_ids(), {}, on);
  double farthest = 0.0;
  for (const KeyFrameId id : scene.map.keyframe_ids()) {
    const Pose& T_WC = scene.map.keyframe(id)->T_WC;
    farthest = std::max(farthest, (T_WC.p() - few.keyframes.at(id).p()).norm());
  }
  EXPECT_LT(farthest, 0.001) << "damped as Ceres does by default it is 50 mm";
}

TEST(LoopCloser, RemovesOutliersOfTheAdjustmentFromTheMap) {
  LoopScene scene(kDrifting);
  LoopCloser closer(scene.model, {}, 0);
  constexpr int kWrongIndex = 20;
  constexpr KeyFrameId kWrong(kWrongIndex);
  PointId point = kNoId;
  std::size_t feature = 0;
  for (int i = 0; i < scene.size(); ++i) {
    const KeyFrameId id = scene.Add(i);
    if (i == kWrongIndex + 3) {
      // A point that others also see is assigned to a feature far away in the image.
      KeyFrame& keyframe = *scene.map.keyframe(kWrong);
      const auto uv = [&](std::size_t f) { return keyframe.frame.features->points[f].uv; };
      for (std::size_t f = 0; f < keyframe.points.size() && point == kNoId; ++f) {
        const MapPoint* seen = scene.map.Find(keyframe.points[f]);
        if (seen != nullptr && seen->observations.size() >= 4) point = seen->id;
        if (point == kNoId) continue;
        while ((uv(feature) - uv(f)).norm() < 100.0) ++feature;
      }
      scene.map.Forget(kWrong, keyframe.points[feature]);
      scene.map.Forget(kWrong, point);
      ASSERT_TRUE(scene.map.Observe(kWrong, static_cast<int>(feature), point));
    }
    closer.InsertKeyFrame(scene.map, id);
    closer.Update(&scene.map);
  }
  closer.Finish(&scene.map);
  ASSERT_FALSE(closer.loops().empty());
  ASSERT_NE(point, kNoId);
  EXPECT_NE(scene.map.keyframe(kWrong)->points[feature], point);
}

TEST(LoopCloser, ConnectsTheTwoSides) {
  LoopScene scene(kDrifting);
  const auto reports = Walk(scene, {});
  const LoopEdge& edge = reports.at(0).loop.edge;
  bool connected = false;
  for (const auto& [id, shared] : scene.map.Covisible(edge.keyframe, 30)) {
    connected = connected || id == edge.match;
  }
  EXPECT_TRUE(connected);
}

TEST(LoopCloser, InTheBackgroundTheMapGrowsAndNewerKeyFramesAreCorrected) {
  LoopScene scene(kDrifting);
  LoopCloserOptions options;
  LoopCloser closer(scene.model, options, 1);
  int i = 0;
  while (!closer.InsertKeyFrame(scene.map, scene.Add(i))) ASSERT_LT(++i, scene.size());
  // Nothing is applied before Update, whatever the other thread has computed.
  const double drifted = scene.Rmse();
  for (++i; i < scene.size(); ++i) {
    EXPECT_FALSE(closer.InsertKeyFrame(scene.map, scene.Add(i))) << "one at a time";
  }
  EXPECT_GT(scene.Rmse(), drifted);
  const auto reports = closer.Finish(&scene.map);
  ASSERT_EQ(reports.size(), 2u);
  EXPECT_EQ(closer.loops().size(), 1u);
  EXPECT_LT(scene.Rmse(), 0.25 * DriftedRmse());
}

TEST(LoopCloser, ANewerLoopDoesNotWaitForTheAdjustmentAfterAnOlderOne) {
  LoopScene scene(kDrifting);
  BundleAdjustmentOptions bundle = kGlobalAdjustment;
  bundle.first_iterations = bundle.second_iterations = 1000;
  LoopCloser closer(scene.model, {}, 1, bundle);
  std::size_t corrections = 0, adjustments = 0;
  const auto count = [&](const std::vector<LoopReport>& reports) {
    for (const LoopReport& report : reports) ++(report.bundle ? adjustments : corrections);
  };
  for (int i = 0; i < scene.size(); ++i) {
    const bool found = closer.InsertKeyFrame(scene.map, scene.Add(i));
    const std::size_t before = corrections;
    while (found && corrections == before) count(closer.Update(&scene.map));
  }
  count(closer.Finish(&scene.map));
  EXPECT_GE(corrections, 2u) << "the scene has two loops at least";
  EXPECT_EQ(closer.loops().size(), corrections);
  EXPECT_GE(adjustments, 1u);
  EXPECT_LE(adjustments, corrections);
  EXPECT_LT(scene.Rmse(), 0.25 * DriftedRmse());
}

TEST(LoopCloser, WorkThatIsNotWaitedForIsGivenUp) {
  LoopScene scene(kDrifting);
  LoopCloserOptions options;
  double before = 0.0;
  {
    LoopCloser closer(scene.model, options, 1);
    int i = 0;
    while (!closer.InsertKeyFrame(scene.map, scene.Add(i))) ASSERT_LT(++i, scene.size());
    before = scene.Rmse();
  }
  EXPECT_EQ(scene.Rmse(), before);
}

TEST(LoopCloser, AppliesNothingOfACancelledLoop) {
  LoopScene scene(kDrifting);
  LoopCloserOptions options;
  LoopCloser closer(scene.model, options, 1);
  int i = 0;
  while (i < scene.size() && !closer.InsertKeyFrame(scene.map, scene.Add(i))) ++i;
  ASSERT_LT(i, scene.size());
  const double before = scene.Rmse();
  closer.Drop();
  EXPECT_FALSE(closer.HasResult());
  EXPECT_TRUE(closer.Finish(&scene.map).empty());
  EXPECT_EQ(scene.Rmse(), before);
  EXPECT_TRUE(closer.loops().empty());
}

TEST(LoopCloser, RepeatsBitForBitInSynchronousMode) {
  LoopScene first(kDrifting), second(kDrifting);
  Walk(first, {});
  Walk(second, {});
  for (const KeyFrameId id : first.map.keyframe_ids()) {
    EXPECT_EQ(first.map.keyframe(id)->T_WC.Matrix(), second.map.keyframe(id)->T_WC.Matrix()) << id;
  }
  EXPECT_EQ(first.map.num<MapPoint>(), second.map.num<MapPoint>());
}

TEST(LoopCloser, ReportsOnceHowUserFactorsMovedKeyFrames) {
  LoopScene plain(kDrifting), scene(kDrifting);
  LoopCloser without(plain.model, {}, 0), closer(scene.model, {}, 0);
  for (int i = 0; i < scene.size() && closer.loops().empty(); ++i) {
    without.InsertKeyFrame(plain.map, plain.Add(i));
    without.Update(&plain.map);
    const KeyFrameId id = scene.Add(i);
    if (i == 1) {
      const auto still =
          std::make_shared<RelativePose>(Pose(), 1e-3 * Eigen::Matrix<double, 6, 6>::Identity());
      scene.map.AddFactor({{{KeyFrameId(0), Pose()}, {id, Pose()}}, kNoId, still, nullptr});
    }
    closer.InsertKeyFrame(scene.map, id);
    EXPECT_TRUE(closer.TakeMovesByFactors().empty());
    closer.Update(&scene.map);
  }
  EXPECT_FALSE(closer.loops().empty());
  EXPECT_EQ(closer.TakeMovesByFactors().size(), scene.map.num_keyframes());
  EXPECT_TRUE(closer.TakeMovesByFactors().empty());
  EXPECT_FALSE(without.loops().empty());
  EXPECT_TRUE(without.TakeMovesByFactors().empty());
}

TEST(LoopCloser, MayBeSwitchedOff) {
  LoopScene scene(kDrifting);
  LoopCloserOptions options;
  options.enabled = false;
  EXPECT_TRUE(Walk(scene, options).empty());
  EXPECT_EQ(scene.Rmse(), DriftedRmse());
}

TEST(LoopCloser, WithoutAdjustmentThePoseGraphAloneIsApplied) {
  LoopScene scene(kDrifting);
  LoopCloserOptions options;
  options.adjust = false;
  const auto reports = Walk(scene, options);
  ASSERT_FALSE(reports.empty());
  for (const LoopReport& report : reports) {
    EXPECT_TRUE(report.accepted);
    EXPECT_FALSE(report.bundle);
  }
  EXPECT_LT(scene.Rmse(), 0.6 * DriftedRmse());
}

// Returns the loop that the detector finds, in a map without any correction.
Loop FindLoop(LoopScene& scene) {
  LoopDetector detector(scene.model);
  for (int i = 0; i < scene.size(); ++i) {
    if (auto loop = detector.Detect(scene.map, scene.Add(i), {})) return *loop;
  }
  throw InvalidArgument("no loop");
}

TEST(LoopCorrection, RejectsALoopThatContradictsTheGraph) {
  LoopScene scene(kDrifting);
  Loop loop = FindLoop(scene);
  loop.edge.Z = loop.edge.Z * Pose::FromTangent({4.0, 0.0, 0.0}, {0.0, 0.0, 1.0});
  const double before = scene.Rmse();
  const auto result = CorrectLoop({}, loop, scene.model, {}, {}, &scene.map);
  EXPECT_FALSE(result.accepted);
  EXPECT_EQ(scene.Rmse(), before);
}

TEST(LoopCorrection, HoldsRollAndPitchWhereGravityIsKnown) {
  LoopScene scene(kDrifting);
  const Loop loop = FindLoop(scene);
  std::vector<Eigen::Vector3d> up;
  for (const KeyFrameId id : scene.map.keyframe_ids()) {
    up.push_back(scene.map.keyframe(id)->T_WC.R().row(2));
  }
  scene.map.SetGravity(Eigen::Vector3d(0, 0, -9.81));
  const double before = scene.Rmse();
  ASSERT_TRUE(CorrectLoop({}, loop, scene.model, {}, {}, &scene.map).accepted);
  EXPECT_LT(scene.Rmse(), 0.75 * before);
  for (const KeyFrameId id : scene.map.keyframe_ids()) {
    // The edge that constrains gravity has a sigma of 1e-3 rad.
    EXPECT_LT((scene.map.keyframe(id)->T_WC.R().row(2).transpose() - up[id.index()]).norm(), 1e-3);
  }
}

TEST(LoopCorrection, WithoutGravityRollAndPitchAreFree) {
  LoopScene scene(kDrifting);
  const Loop loop = FindLoop(scene);
  const auto up_of = [&](KeyFrameId id) {
    return Eigen::Vector3d(scene.map.keyframe(id)->T_WC.R().row(2));
  };
  const Eigen::Vector3d before = up_of(loop.edge.keyframe);
  ASSERT_TRUE(CorrectLoop({}, loop, scene.model, {}, {}, &scene.map).accepted);
  EXPECT_GT((up_of(loop.edge.keyframe) - before).norm(), 1e-3);
}

}  // namespace
}  // namespace highwall::loop_closer_test
