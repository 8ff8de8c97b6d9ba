#include <gtest/gtest.h>

#include "map/map_edit.h"
#include "support/id_literals.h"
#include "support/synthetic_scene.h"

namespace highwall::map_edit_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::PositionError;
using testing::Scene;
using testing::SceneMap;
using testing::operator""_kf;

const Pose kPoses[] = {Pose::FromTangent({0, 0, 0}, {0, -0.2, 0}),
                       Pose::FromTangent({0.2, 0, 0}, {0, 0.0, 0}),
                       Pose::FromTangent({0.3, 0.1, 0}, {0, 0.2, 0})};
const Pose kMove = Pose::FromTangent({0.3, -0.1, 0.2}, {0.02, 0.1, -0.03});

class MapEditTest : public ::testing::Test {
 protected:
  MapEditTest() {
    for (int i = 0; i < 2; ++i) scene_map.Add(Look(scene, IdealSensor(), kPoses[i]), kPoses[i]);
  }

  Map& map() { return scene_map.map; }

  const Scene scene = MakeScene(5, 300, 30);
  SceneMap scene_map{scene};
};

TEST_F(MapEditTest, LandmarksFollowTheKeyFrameThatSawThemFirst) {
  const auto before = GeometryOf(map());
  MoveKeyFrames({0_kf, 1_kf}, {kPoses[0], kMove * kPoses[1]}, &map());
  EXPECT_LT(PositionError(map().keyframe(1_kf)->T_WC, kMove * kPoses[1]), 1e-12);
  for (const PointId id : map().ids<MapPoint>()) {
    const MapPoint& point = *map().Find(id);
    const Eigen::Vector3d& old = before.landmarks.points.at(id);
    const Eigen::Vector3d expected =
        point.observations.front().keyframe == 0_kf ? old : kMove * old;
    EXPECT_LT((point.p_W - expected).norm(), 1e-12);
  }
  for (const LineId id : map().ids<MapLine>()) {
    const MapLine& line = *map().Find(id);
    const Segment3& old = before.landmarks.lines.at(id);
    const Segment3 expected = line.observations.front().keyframe == 0_kf ? old : kMove * old;
    EXPECT_LT((line.segment_W.p() - expected.p()).norm(), 1e-12);
  }
}

TEST_F(MapEditTest, MovesWhatWasAddedSinceTheCopy) {
  MapEdit correction;
  Map copy = map().Clone();
  MoveKeyFrames({0_kf, 1_kf}, {kPoses[0], kMove * kPoses[1]}, &copy);
  const PointId moved = copy.keyframe(1_kf)->points.front();
  copy.Find(moved)->p_W += Eigen::Vector3d(0.01, 0.02, 0.03);
  correction.after = GeometryOf(copy);

  // In the meantime a keyframe with its own landmarks was added, and a point was removed.
  scene_map.Add(Look(scene, IdealSensor(), kPoses[2]), kPoses[2]);
  const PointId fresh = map().Add<MapPoint>({1, 2, 3}, 2).id;
  int free = 0;
  while (map().keyframe(2_kf)->points[static_cast<std::size_t>(free)] != kNoId) {
    if (++free == static_cast<int>(map().keyframe(2_kf)->points.size())) {
      map().Forget(2_kf, map().keyframe(2_kf)->points[0]);
      free = 0;
    }
  }
  ASSERT_TRUE(map().Observe(2_kf, free, fresh));
  const PointId lost = map().keyframe(0_kf)->points.back();
  map().Remove(lost);

  Apply(correction, &map());
  EXPECT_EQ(map().keyframe(0_kf)->T_WC.Matrix(), kPoses[0].Matrix());
  EXPECT_LT(PositionError(map().keyframe(1_kf)->T_WC, kMove * kPoses[1]), 1e-12);
  EXPECT_LT(PositionError(map().keyframe(2_kf)->T_WC, kMove * kPoses[2]), 1e-12);
  EXPECT_LT((map().Find(fresh)->p_W - kMove * Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_EQ(map().Find(lost), nullptr);
  if (map().Find(moved) != nullptr) {
    EXPECT_LT((map().Find(moved)->p_W - copy.Find(moved)->p_W).norm(), 1e-12);
  }
}

TEST_F(MapEditTest, DoesNotCorrectAnErrorTwiceThatWasCorrectedMeanwhile) {
  // The copy and a local adjustment of the map move keyframe 1 and its landmarks to one place.
  Map copy = map().Clone();
  const auto adjust = [](Map* m) {
    MoveKeyFrames({0_kf, 1_kf}, {kPoses[0], kMove * kPoses[1]}, m);
  };
  adjust(&copy);
  scene_map.Add(Look(scene, IdealSensor(), kPoses[2]), kPoses[2]);
  adjust(&map());
  const auto now = GeometryOf(map());
  MapEdit correction;
  correction.after = GeometryOf(copy);
  Apply(correction, &map());
  for (const KeyFrameId id : map().keyframe_ids()) {
    EXPECT_LT(PositionError(map().keyframe(id)->T_WC, now.keyframes.at(id)), 1e-12) << id;
  }
  for (const PointId id : map().ids<MapPoint>()) {
    EXPECT_LT((map().Find(id)->p_W - now.landmarks.points.at(id)).norm(), 1e-12);
  }
  for (const LineId id : map().ids<MapLine>()) {
    EXPECT_LT((map().Find(id)->segment_W.p() - now.landmarks.lines.at(id).p()).norm(), 1e-12);
  }
}

TEST_F(MapEditTest, RemovesObservationsThatTheCopyFoundWrong) {
  const KeyFrame& keyframe = *map().keyframe(1_kf);
  const PointId point = keyframe.points[0], other = keyframe.points[1];
  const LineId line = keyframe.lines[0];
  MapEdit correction;
  correction.after = GeometryOf(map());
  // The last two no longer exist.
  correction.outliers = {{{1_kf, point}, {77_kf, other}, {1_kf, PointId(12345)}}, {{1_kf, line}}};
  Apply(correction, &map());
  EXPECT_EQ(keyframe.points[0], kNoId);
  EXPECT_EQ(keyframe.points[1], other);
  EXPECT_EQ(keyframe.lines[0], kNoId);
}

TEST_F(MapEditTest, ACloneIsAMapOfItsOwn) {
  Map clone = map().Clone();
  clone.keyframe(0_kf)->T_WC = kMove;
  clone.Remove(clone.ids<MapPoint>().front());
  EXPECT_EQ(map().keyframe(0_kf)->T_WC.Matrix(), kPoses[0].Matrix());
  EXPECT_EQ(map().num<MapPoint>(), clone.num<MapPoint>() + 1);
  EXPECT_EQ(clone.keyframe(1_kf)->frame.features, map().keyframe(1_kf)->frame.features);
}

TEST_F(MapEditTest, ACloneOfSomeKeyframesHasThemAndWhatTheySeeUnderTheSameIds) {
  const std::vector<KeyFrameId> some{1_kf};
  Map clone = map().CloneOf(some);
  EXPECT_EQ(clone.keyframe_ids(), some);
  EXPECT_EQ(clone.keyframe(1_kf)->T_WC.Matrix(), map().keyframe(1_kf)->T_WC.Matrix());
  std::vector<PointId> seen = map().SeenBy<MapPoint>(some);
  EXPECT_EQ(clone.ids<MapPoint>(), seen);
  EXPECT_EQ(clone.ids<MapLine>(), map().SeenBy<MapLine>(some));
  for (const PointId id : seen) {
    EXPECT_EQ(clone.Find(id)->p_W, map().Find(id)->p_W);
    ASSERT_EQ(clone.Find(id)->observations.size(), 1u);
    EXPECT_EQ(clone.Find(id)->observations[0].keyframe, 1_kf);
  }
  // An added landmark has an id of its own.
  EXPECT_GT(clone.Add<MapPoint>({0, 0, 1}, 0).id, seen.back());
}

}  // namespace
}  // namespace highwall::map_edit_test
