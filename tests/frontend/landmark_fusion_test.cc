#include <gtest/gtest.h>

#include "map/landmark_fusion.h"
#include "support/id_literals.h"
#include "support/synthetic_scene.h"

namespace highwall::landmark_fusion_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::Scene;
using testing::SceneMap;
using testing::operator""_kf;

const Pose kPoses[] = {Pose::FromTangent({0, 0, 0}, {0, -0.2, 0}),
                       Pose::FromTangent({0.2, 0, 0}, {0, 0.0, 0})};

// Two keyframes and, in another world at the same place, a third one: the two sides of a loop after
// it is closed.
class LandmarkFusionTest : public ::testing::Test {
 protected:
  LandmarkFusionTest() {
    for (const Pose& pose : kPoses) old_side.Add(Look(scene, IdealSensor(), pose), pose);
    new_side.map = old_side.map.Clone();
    id = new_side.Add(Look(scene, IdealSensor(), kPoses[1]), kPoses[1]);
  }

  Map& map() { return new_side.map; }
  const KeyFrame& keyframe() { return *map().keyframe(id); }
  MapFusion Fuse(const FusionOptions& options) {
    const std::vector<KeyFrameId> old{0_kf, 1_kf};
    return FuseLandmarks(id, old, matcher, options, &map());
  }

  const Scene scene = MakeScene(5, 300, 30);
  const MeasurementModel model{IdealSensor(), {}};
  const MapMatcher matcher{model};
  SceneMap old_side{scene}, new_side{scene};
  KeyFrameId id;
};

TEST_F(LandmarkFusionTest, TwofoldLandmarksBecomeOne) {
  const PointId from = map().keyframe(1_kf)->points.back(), into = map().keyframe(0_kf)->points[0];
  const LineId line = map().keyframe(0_kf)->lines[0];
  ASSERT_NE(from, into);
  MapFusion fusion;
  fusion.merged.points = {{from, into}, {from, into}, {PointId(12345), into}};
  fusion.merged.lines = {{LineId(54321), line}};
  fusion.observed.points = {{99_kf, 0, into}};
  Apply(fusion, &map());
  EXPECT_EQ(map().Find(from), nullptr);
  ASSERT_NE(map().Find(into), nullptr);
  EXPECT_NE(map().Find(line), nullptr);
}

TEST_F(LandmarkFusionTest, LandmarksOfAnotherPartAreFoundInAKeyFrame) {
  const Map before = map().Clone();
  const MapFusion fusion = Fuse({});
  EXPECT_GT(fusion.merged.points.size(), keyframe().points.size() / 2);
  EXPECT_GT(fusion.merged.lines.size(), 3u);
  EXPECT_TRUE(fusion.observed.points.empty()) << "every feature had a landmark";
  for (const auto& [from, into] : fusion.merged.points) {
    EXPECT_LT((before.Find(from)->p_W - before.Find(into)->p_W).norm(), 0.02);
    EXPECT_EQ(map().Find(from), nullptr);
  }
  EXPECT_EQ(map().num<MapPoint>(), before.num<MapPoint>() - fusion.merged.points.size());
  EXPECT_EQ(map().num<MapLine>(), before.num<MapLine>() - fusion.merged.lines.size());
}

TEST_F(LandmarkFusionTest, TheSideThatIsLookedForStaysUnlessTheOtherIsObservedMore) {
  // One point is observed by the keyframe and by two additional ones, created here.
  const PointId observed_more = keyframe().points.front();
  const Frame frame = keyframe().frame;
  for (int i = 0; i < 2; ++i) {
    const KeyFrameId more = map().AddKeyFrame(frame, kPoses[1]).id;
    map().Observe(more, 0, observed_more);
  }
  Map other_rule = map().Clone();
  Fuse({});
  EXPECT_EQ(map().Find(observed_more), nullptr);
  std::swap(other_rule, map());
  const MapFusion fusion = Fuse({.keep_more_observed = true});
  ASSERT_NE(map().Find(observed_more), nullptr);
  EXPECT_EQ(map().Find(observed_more)->observations.size(), 5u)
      << "three of its own, two of the other";
  const auto stays = std::count_if(fusion.merged.points.begin(), fusion.merged.points.end(),
                                   [&](const auto& p) { return p.second == observed_more; });
  EXPECT_EQ(stays, 1);
}

TEST_F(LandmarkFusionTest, LinesThatTheKeyFrameObservesStayApartWhereTheyAreNotToMerge) {
  const std::size_t before = map().num<MapLine>();
  const MapFusion fusion = Fuse({.merge_lines = false});
  EXPECT_TRUE(fusion.merged.lines.empty());
  EXPECT_TRUE(fusion.observed.lines.empty()) << "every feature had a landmark";
  EXPECT_EQ(map().num<MapLine>(), before);
}

TEST_F(LandmarkFusionTest, AFeatureWhoseDepthContradictsTheLandmarkIsNoObservationOfIt) {
  const PointId behind = map().keyframe(1_kf)->points.front();
  Eigen::Vector3d& p_W = map().Find(behind)->p_W;
  p_W = kPoses[1].p() + 1.15 * (p_W - kPoses[1].p());  // on the same pixel
  Map without_bounds = map().Clone();
  Fuse({});
  EXPECT_EQ(map().Find(behind)->observations.back().keyframe, 1_kf);
  std::swap(without_bounds, map());
  Fuse({.inliers = {.chi2_3 = 1e9}});
  EXPECT_EQ(map().Find(behind)->observations.back().keyframe, id);
}

}  // namespace
}  // namespace highwall::landmark_fusion_test
