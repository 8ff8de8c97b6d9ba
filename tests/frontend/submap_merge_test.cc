#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "loops/loop_closer.h"
#include "loops/submap_merge.h"
#include "support/id_literals.h"
#include "support/loop_scene.h"

namespace highwall::submap_merge_test {
namespace {

using testing::LoopScene;
using testing::LoopSceneOptions;
using testing::operator""_kf;

// The second half of the walk begins at another place in a separate map and returns to its
// beginning: in view from the 28th keyframe on.
const LoopSceneOptions kTwoSubmaps{.drift = {0.002, 0.001, 0.0}, .submap_from = 18, .jump = 12};
constexpr int kInView = 28;

struct Walked {
  std::vector<LoopReport> reports;
  int refused = 0;
  int merged_at = -1;  // keyframe
};

Walked Walk(LoopScene& scene, const LoopCloserOptions& options) {
  LoopCloser closer(scene.model, options, 0);
  Walked walked;
  for (int i = 0; i < scene.size(); ++i) {
    closer.InsertKeyFrame(scene.map, scene.Add(i));
    walked.refused += static_cast<int>(closer.TakeRefused().size());
    for (LoopReport& report : closer.Update(&scene.map)) {
      if (report.merge && walked.merged_at < 0) walked.merged_at = i;
      walked.reports.push_back(std::move(report));
    }
  }
  return walked;
}

TEST(SubmapMerge, JoinsTheSubmapsThatShowOnePlace) {
  LoopScene scene(kTwoSubmaps);
  const Walked walked = Walk(scene, {});
  ASSERT_GE(walked.reports.size(), 2U);
  const LoopReport& first = walked.reports[0];
  EXPECT_TRUE(first.accepted) << first.message;
  ASSERT_TRUE(first.merge);
  EXPECT_EQ(first.merge->root, kFirstSubmap);
  EXPECT_EQ(first.merge->other, SubmapId(1));
  EXPECT_EQ(first.merge->moved, SubmapId(1));
  EXPECT_GT(first.fused_points, 30);
  ASSERT_TRUE(walked.reports[1].bundle);
  EXPECT_TRUE(walked.reports[1].bundle->usable);
  EXPECT_EQ(scene.map.roots(), std::vector<SubmapId>{kFirstSubmap});
  // There are 24 steps of 2.2 mm on either side of the seam; unmerged, the worlds were metres off.
  EXPECT_LT(scene.Rmse(), 0.06);
}

TEST(SubmapMerge, OneKeyFrameIsNotEnoughUnlessItsMatchRatioIsDecisive) {
  const auto merged_at = [](double decisive_ratio) {
    LoopScene scene(kTwoSubmaps);
    LoopCloserOptions options;
    options.detector.decisive_ratio = decisive_ratio;
    return Walk(scene, options).merged_at;
  };
  const int first = merged_at(1.0);
  EXPECT_GE(first, kInView);
  EXPECT_EQ(merged_at(100.0), first + LoopDetectorOptions().consistency - 1);
}

TEST(SubmapMerge, ASimilarPlaceOfOtherGeometryIsNotMerged) {
  LoopSceneOptions options = kTwoSubmaps;
  options.shuffled_return = true;
  LoopScene scene(options);
  const Walked walked = Walk(scene, {});
  EXPECT_TRUE(walked.reports.empty());
  EXPECT_EQ(scene.map.roots().size(), 2U);
}

TEST(SubmapMerge, APlaceThatHasMostlyChangedIsNotMerged) {
  LoopSceneOptions options = kTwoSubmaps;
  options.strange_return = 0.6;
  LoopScene scene(options);
  LoopCloserOptions careful;
  careful.detector.min_match_ratio_across_submaps = 1.0;
  const Walked walked = Walk(scene, careful);
  EXPECT_EQ(walked.merged_at, -1);
  EXPECT_GT(walked.refused, 0) << "and the reason is reported";
}

// Returns the first keyframe after which, as the last one, the submaps are merged; -1: none.
int MergedAtTheEnd(const LoopSceneOptions& scene_options, LoopCloserOptions options = {}) {
  options.detector.consistency = 30;  // keyframes in a row: none is merged on the way
  options.detector.decisive_ratio = 100.0;
  for (int last = kInView; last < LoopScene(scene_options).size(); ++last) {
    LoopScene scene(scene_options);
    LoopCloser closer(scene.model, options, 0);
    for (int i = 0; i <= last; ++i) {
      EXPECT_FALSE(closer.InsertKeyFrame(scene.map, scene.Add(i))) << i;
    }
    const std::vector<KeyFrameId> all = scene.map.keyframe_ids();
    closer.InsertLast(scene.map, std::span(all).last(3));
    closer.Finish(&scene.map);
    if (scene.map.roots().size() == 1) return last;
  }
  return -1;
}

TEST(SubmapMerge, AtTheEndTwoKeyFramesThatAgreeAreEnough) {
  LoopScene scene(kTwoSubmaps);
  LoopCloserOptions one_is_enough;
  one_is_enough.detector.decisive_ratio = 1.0;
  const int first = Walk(scene, one_is_enough).merged_at;
  EXPECT_EQ(MergedAtTheEnd(kTwoSubmaps), first + 1);
}

TEST(SubmapMerge, AtTheEndKeyFramesThatDisagreeAreNotEnough) {
  LoopCloserOptions strict;
  strict.graph.max_loop_chi2 = 1e-6;
  EXPECT_EQ(MergedAtTheEnd(kTwoSubmaps, strict), -1);
}

TEST(SubmapMerge, AtTheEndAPlaceThatHasMostlyChangedIsNotMerged) {
  LoopSceneOptions options = kTwoSubmaps;
  options.strange_return = 0.6;
  EXPECT_EQ(MergedAtTheEnd(options), -1);
}

// A merge on another thread, while the submap that moves grows: new keyframes and landmarks move
// with it.
TEST(SubmapMerge, MovesWhatIsMappedDuringTheMerge) {
  LoopScene scene(kTwoSubmaps);
  LoopCloser closer(scene.model, {}, 1);
  int i = 0;
  while (!closer.InsertKeyFrame(scene.map, scene.Add(i))) ASSERT_LT(++i, scene.size());
  const Pose before = scene.map.keyframe(KeyFrameId(i))->T_WC;
  const KeyFrameId last = scene.Add(++i);
  const Pose step = before.Inverse() * scene.map.keyframe(last)->T_WC;
  const std::vector<LoopReport> reports = closer.Finish(&scene.map);
  ASSERT_FALSE(reports.empty());
  EXPECT_TRUE(reports[0].merge);
  EXPECT_EQ(scene.map.RootOf(last), kFirstSubmap);
  const Pose after =
      scene.map.keyframe(KeyFrameId(i - 1))->T_WC.Inverse() * scene.map.keyframe(last)->T_WC;
  EXPECT_LT((after.p() - step.p()).norm(), 1e-9) << "rigidly with the one before";
}

class PlanMergeTest : public ::testing::Test {
 protected:
  PlanMergeTest() : scene({.submap_from = 24}) {
    for (int i = 0; i < 26; ++i) scene.Add(i);
    edge = {.match = 23_kf, .keyframe = 24_kf, .Z = scene.truth[23].Inverse() * scene.truth[24]};
  }
  // Returns the distance between the keyframe's position by the loop and the true one.
  double Error() { return (scene.map.keyframe(24_kf)->T_WC.p() - scene.truth[24].p()).norm(); }

  LoopScene scene;
  LoopEdge edge;
  std::string message;
  const SubmapId second{1};
  const Eigen::Vector3d down{0, 0, -9.81};
};

TEST_F(PlanMergeTest, TheYoungerMovesToWhereTheLoopHasIt) {
  const auto merge = PlanMerge(scene.map, edge, {}, &message);
  ASSERT_TRUE(merge);
  Apply(*merge, &scene.map);
  EXPECT_LT(Error(), 1e-12);  // the map is exact
  EXPECT_EQ(scene.map.RootOf(25_kf), kFirstSubmap);
}

TEST_F(PlanMergeTest, TheWorldThatKnowsGravityStays) {
  scene.map.SetGravity(down, second);
  const Pose before = scene.map.keyframe(24_kf)->T_WC;
  const auto merge = PlanMerge(scene.map, edge, {}, &message);
  ASSERT_TRUE(merge);
  EXPECT_EQ(merge->moved, kFirstSubmap);
  Apply(*merge, &scene.map);
  EXPECT_EQ(scene.map.keyframe(24_kf)->T_WC.Matrix(), before.Matrix());
  EXPECT_EQ(scene.map.gravity_W(), down);
  const Pose Z = scene.map.keyframe(23_kf)->T_WC.Inverse() * scene.map.keyframe(24_kf)->T_WC;
  EXPECT_LT((Z.p() - edge.Z.p()).norm(), 1e-12);
}

TEST_F(PlanMergeTest, ALoopThatTiltsGravityIsRefusedWithTheAngle) {
  scene.map.SetGravity(down, kFirstSubmap);
  scene.map.SetGravity(down, second);
  const auto tilted = [&](double angle) {
    LoopEdge tilt = edge;
    tilt.Z = edge.Z * Pose::FromTangent({0, 0, 0}, {angle, 0, 0});
    return PlanMerge(scene.map, tilt, {}, &message);
  };
  EXPECT_FALSE(tilted(0.2));
  EXPECT_NE(message.find("tilts gravity by 11.4"), std::string::npos) << message;
  const auto merge = tilted(0.03);
  ASSERT_TRUE(merge) << message;
  Apply(*merge, &scene.map);
  const Eigen::Vector3d up = merge->T_new_old.q() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(up.z(), 1.0, 1e-15) << "turned about the vertical alone";
  EXPECT_LT(Error(), 1e-12) << "and moved about the keyframe";
}

TEST_F(PlanMergeTest, ALoopMayTiltGravityWhereItsMatchesLeaveTheRotationUncertain) {
  scene.map.SetGravity(down, kFirstSubmap);
  scene.map.SetGravity(down, second);
  LoopEdge tilt = edge;
  tilt.Z = edge.Z * Pose::FromTangent({0, 0, 0}, {0.2, 0, 0});
  tilt.covariance(5, 5) = 0.04;  // about the optical axis
  EXPECT_FALSE(PlanMerge(scene.map, tilt, {}, &message));
  tilt.covariance(5, 5) = 0.0;
  tilt.covariance(3, 3) = 0.04;  // about the axis of the tilt: 0.2 rad
  EXPECT_TRUE(PlanMerge(scene.map, tilt, {}, &message)) << message;
}

TEST_F(PlanMergeTest, TwoLoopsAgreeWithinWhatTheirMatchesKnow) {
  const LoopEdge next{
      .match = 22_kf, .keyframe = 25_kf, .Z = scene.truth[22].Inverse() * scene.truth[25]};
  EXPECT_LT(MergeChi2(scene.map, edge, next, {}), 1e-18);  // the map is exact: rounding
  // Off by 10 cm along x, with the errors of two loops, 2 cm and 10 mrad each: what the first one
  // is uncertain by in rotation moves the next keyframe.
  LoopEdge off = next;
  off.Z = next.Z * Pose::FromTangent({0.1, 0, 0}, {0, 0, 0});
  const double step = (scene.truth[25].p() - scene.truth[24].p()).norm();
  const double least = 0.01 / (2.0 * 4e-4 + 1e-4 * step * step), most = 0.01 / (2.0 * 4e-4);
  EXPECT_GE(MergeChi2(scene.map, edge, off, {}), least);
  EXPECT_LE(MergeChi2(scene.map, edge, off, {}), most);
  // Matches that leave x open to a metre agree with it, wherever the uncertain loop stands.
  off.covariance(0, 0) = 1.0;
  EXPECT_LT(MergeChi2(scene.map, edge, off, {}), 0.0101);
  off.covariance.setZero();
  LoopEdge uncertain = edge;
  uncertain.covariance = Eigen::Matrix<double, 6, 6>::Identity();
  EXPECT_LT(MergeChi2(scene.map, uncertain, off, {}), 0.0101);
}

// A person stands at different places in the two submaps.
TEST_F(PlanMergeTest, DynamicObjectsDoNotContradictAPlace) {
  const DepthGrid grid(scene.model.camera());
  const cv::Size size(grid.camera().width, grid.camera().height);
  const auto show = [&](KeyFrameId id, int column) {
    KeyFrame& keyframe = *scene.map.keyframe(id);
    keyframe.T_WC = Pose();
    keyframe.depth_grid = cv::Mat(size, CV_32FC1, cv::Scalar(3.0));
    keyframe.depth_grid.colRange(column, column + 20).setTo(2.0F);
    return keyframe.depth_grid.colRange(column, column + 20);
  };
  cv::Mat before = show(23_kf, 10);
  show(24_kf, 50);
  const SubmapMerge merge{
      .root = kFirstSubmap, .other = second, .moved = second, .T_new_old = Pose()};
  const auto share = [&] {
    return MergeContradiction(scene.map, merge, grid, DepthNoise::Kinect());
  };
  ASSERT_TRUE(share());
  EXPECT_GT(*share(), 0.2);
  before.setTo(0.0F);  // as in a keyframe with the dynamic object masked out
  ASSERT_TRUE(share());
  EXPECT_EQ(*share(), 0.0);
}

}  // namespace
}  // namespace highwall::submap_merge_test
