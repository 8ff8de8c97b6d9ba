#include "tracking/landmarks_around.h"

#include <gtest/gtest.h>

#include "support/id_literals.h"
#include "support/synthetic_scene.h"

namespace highwall::landmarks_around_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::Scene;
using testing::SceneMap;
using testing::operator""_kf;

TEST(LandmarksAround, FindsWhatTheMapFindsWhicheverKeyframesComeAndGo) {
  const Scene scene = MakeScene(5, 300, 30);
  SceneMap scene_map{scene};
  for (int i = 0; i < 4; ++i) {
    const Pose T_WC = Pose::FromTangent({0.1 * i, 0, 0}, {0, 0.4 * i - 0.6, 0});
    scene_map.Add(Look(scene, IdealSensor(), T_WC), T_WC);
  }
  const Map& map = scene_map.map;
  LandmarksAround around(map);
  const std::vector<std::vector<KeyFrameId>> visits{
      {0_kf}, {1_kf, 0_kf}, {}, {3_kf, 1_kf, 2_kf}, {1_kf, 3_kf}, {0_kf, 1_kf, 2_kf, 3_kf}, {2_kf}};
  for (const std::vector<KeyFrameId>& keyframes : visits) {
    around.MoveTo(keyframes);
    ForEachKind([&]<class Landmark>() {
      // The second query shows that the first one hid its exceptions only for itself.
      LandmarkIds<Landmark> except = PartOf<Landmark>(*map.keyframe(1_kf));
      except.resize(except.size() / 2);
      except.push_back(kNoId);
      if (except.size() > 1) except.push_back(except.front());
      EXPECT_EQ(around.Except<Landmark>(except), map.SeenBy<Landmark>(keyframes, except));
      EXPECT_EQ(around.Except<Landmark>({}), map.SeenBy<Landmark>(keyframes));
    });
  }
  EXPECT_FALSE(map.SeenBy<MapPoint>(visits.back()).empty());
}

}  // namespace
}  // namespace highwall::landmarks_around_test
