#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/loops/merge_maps.h>
#include <highwall/frontend/map/keyframe_index.h>

#include "local/corner_patch.h"
#include "map/add_map.h"
#include "support/id_literals.h"
#include "support/loop_scene.h"
#include "support/message_of.h"
#include "support/position_in_frame.h"

namespace highwall::merge_maps_test {
namespace {

using testing::LoopScene;
using testing::operator""_kf;

// A session along the ring (LoopScene) with a different world frame.
struct SessionOfRing {
  // begin, count: of the steps of the walk. seed: of the place.
  SessionOfRing(int begin, int count, const Pose& T_world_ring, unsigned seed = 11)
      : scene({.seed = seed, .submap_from = 0, .jump = begin}) {
    for (int i = 0; i < count; ++i) scene.Add(i);
    scene.map.Transform(T_world_ring);
  }

  LoopScene scene;
};

const Pose kMonday = Pose::FromTangent({3, 1, 0.5}, {0.1, 0.2, 0.3});
const Pose kTuesday = Pose::FromTangent({-2, 4, 0}, {0, 0.1, -1.2});
const Pose kWednesday = Pose::FromTangent({0, 0, 9}, {0.3, 0, 0});

// Returns the largest error of the keyframes [m] in the world frame of the first session.
double WorstError(const MergedMaps& merged, std::size_t map, const SessionOfRing& session,
                  const Pose& T_world_ring) {
  double worst = 0.0;
  for (std::size_t i = 0; i < merged.keyframes[map].size(); ++i) {
    const Pose truth = T_world_ring * session.scene.truth[i];
    const Pose& T_WC = merged.map.keyframe(merged.keyframes[map][i])->T_WC;
    worst = std::max(worst, (T_WC.p() - truth.p()).norm());
  }
  return worst;
}

int CountMerges(const MergedMaps& merged) {
  return static_cast<int>(std::ranges::count_if(merged.loops, [](const LoopReport& report) {
    return report.accepted && report.merge.has_value();
  }));
}

// Corners are off by 0.7 px, 4 mm at three metres; this bounds the worst of some twenty pairs.
constexpr double kAtTheSeam = 0.015;  // [m]
// Adjusted walks of six to nine metres drift by half a percent, also a single one.
constexpr double kDrift = 0.045;  // [m]

// Returns the largest distance [m] between keyframes of two sessions at one place; the second
// session starts `lag` keyframes further on.
double WorstSeam(const MergedMaps& merged, std::size_t a, std::size_t b, std::size_t lag) {
  double worst = 0.0;
  for (std::size_t i = lag; i < merged.keyframes[a].size() && i - lag < merged.keyframes[b].size();
       ++i) {
    const Pose off = merged.map.keyframe(merged.keyframes[a][i])->T_WC.Inverse() *
                     merged.map.keyframe(merged.keyframes[b][i - lag])->T_WC;
    worst = std::max(worst, off.p().norm());
  }
  return worst;
}

TEST(MergeMaps, TwoSessionsOfOnePlaceBecomeOneMapInTheWorldOfTheFirst) {
  SessionOfRing monday(0, 24, kMonday), tuesday(10, 24, kTuesday);
  std::vector<Map> maps;
  maps.push_back(std::move(monday.scene.map));
  maps.push_back(std::move(tuesday.scene.map));
  const std::size_t points = maps[0].num<MapPoint>() + maps[1].num<MapPoint>();
  std::size_t searched = 0;
  const MergedMaps merged = MergeMaps(monday.scene.model_sensor, std::move(maps), {},
                                      [&](std::size_t done, std::size_t total) {
                                        EXPECT_EQ(done, ++searched);
                                        EXPECT_EQ(total, 24U);
                                      });
  EXPECT_EQ(searched, 24U);
  ASSERT_EQ(merged.keyframes.size(), 2U);
  EXPECT_EQ(merged.keyframes[0].size(), 24U);
  EXPECT_EQ(merged.keyframes[1].size(), 24U);
  EXPECT_EQ(CountMerges(merged), 1);
  ASSERT_EQ(merged.map.roots().size(), 1U);
  EXPECT_LT(merged.map.num<MapPoint>(), points - 300) << "what both have seen is one";
  EXPECT_LT(WorstSeam(merged, 0, 1, 10), kAtTheSeam) << "one place is one";
  EXPECT_LT(WorstError(merged, 0, monday, kMonday), kDrift);
  EXPECT_LT(WorstError(merged, 1, tuesday, kMonday), kDrift) << "of the correction of its world";
}

TEST(MergeMaps, SessionsOfTwoPlacesStayApartAndWhereTheyAre) {
  SessionOfRing monday(0, 16, kMonday), elsewhere(4, 16, kTuesday, 77);
  std::vector<Pose> before;
  for (const KeyFrameId id : elsewhere.scene.map.keyframe_ids()) {
    before.push_back(elsewhere.scene.map.keyframe(id)->T_WC);
  }
  std::vector<Map> maps;
  maps.push_back(std::move(monday.scene.map));
  maps.push_back(std::move(elsewhere.scene.map));
  const MergedMaps merged = MergeMaps(monday.scene.model_sensor, std::move(maps), {});
  EXPECT_EQ(merged.map.roots().size(), 2U);
  EXPECT_EQ(CountMerges(merged), 0);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(merged.map.keyframe(merged.keyframes[1][i])->T_WC.Matrix(), before[i].Matrix());
  }
}

TEST(MergeMaps, ASessionJoinsTwoThatDoNotMeetEachOther) {
  SessionOfRing begin(0, 14, kMonday), end(24, 14, kTuesday), between(6, 26, kWednesday);
  std::vector<Map> maps;
  maps.emplace_back();  // of a session without any image
  for (SessionOfRing* session : {&begin, &end, &between}) {
    maps.push_back(std::move(session->scene.map));
  }
  const MergedMaps merged = MergeMaps(begin.scene.model_sensor, std::move(maps), {});
  EXPECT_TRUE(merged.keyframes[0].empty());
  EXPECT_EQ(CountMerges(merged), 2);
  EXPECT_EQ(merged.map.roots().size(), 1U);
  EXPECT_LT(WorstSeam(merged, 1, 3, 6), kAtTheSeam);
  EXPECT_LT(WorstSeam(merged, 3, 2, 18), kAtTheSeam);
  EXPECT_LT(WorstError(merged, 1, begin, kMonday), kDrift);
  EXPECT_LT(WorstError(merged, 2, end, kMonday), kDrift);
}

TEST(MergeMaps, NothingOfNothingIsNothing) {
  EXPECT_EQ(MergeMaps({}, {}).map.num_keyframes(), 0U);
  EXPECT_EQ(MergeMaps({}, std::vector<Map>(2)).keyframes.size(), 2U);
}

TEST(AddMap, IdsAreNewAndAllElseIsAsItWas) {
  SessionOfRing monday(0, 6, kMonday), tuesday(20, 6, kTuesday);
  Map& map = monday.scene.map;
  Map& other = tuesday.scene.map;
  // The other map has a submap of its own, one that is merged with the first, and gaps.
  const Frame frame = other.keyframe(0_kf)->frame;
  const SubmapId joined = other.AddSubmap(), apart = other.AddSubmap();
  other.AddKeyFrame(frame, Pose(), joined);
  other.AddKeyFrame(frame, Pose(), apart);
  other.Join(other.keyframe(0_kf)->submap, joined);
  const Eigen::Vector3d down(0.0, 0.0, -9.8);
  other.SetGravity(down, apart);
  other.RemoveKeyFrame(2_kf, 1_kf);
  other.keyframe(3_kf)->found = 0.625;
  other.keyframe(3_kf)->depth_grid = cv::Mat(2, 3, CV_32FC1, cv::Scalar(1.5));
  other.Remove(other.ids<MapPoint>().front());
  const ReferenceFrameId known = map.factors().AddFrame({}),
                         marker = other.factors().AddFrame({.upright = false});
  const Pose T_FW = Pose::FromTangent({1, 2, 3}, {0, 0.1, 0.2});
  other.factors().Place(marker, apart, T_FW);
  other.AddFactor({{{other.keyframe_ids().back(), T_FW}},
                   marker,
                   testing::PositionInFrame({4, 5, 6}, 0.1),
                   nullptr});
  const std::size_t keyframes = map.num_keyframes(), points = map.num<MapPoint>();
  const std::size_t lines = map.num<MapLine>();
  other.Find(other.ids<MapPoint>().front())->patch = std::make_shared<const CornerPatch>();
  const MapPoint last_point = *map.Find(map.ids<MapPoint>().back());

  const std::vector<KeyFrameId> added = AddMap(other, &map);
  ASSERT_EQ(added.size(), other.num_keyframes());
  EXPECT_EQ(map.num_keyframes(), keyframes + added.size());
  EXPECT_EQ(map.num<MapPoint>(), points + other.num<MapPoint>());
  EXPECT_EQ(map.num<MapLine>(), lines + other.num<MapLine>());
  EXPECT_EQ(map.roots().size(), 3U);
  EXPECT_EQ(map.RootOf(added[0]), map.RootOf(added[5])) << "joined";
  EXPECT_NE(map.RootOf(added[0]), map.RootOf(added[6])) << "apart";
  EXPECT_EQ(map.gravity_W(*map.RootOf(added[6])), down);
  EXPECT_FALSE(map.gravity_W(*map.RootOf(added[0])));
  ASSERT_EQ(map.factors().all().size(), 1U);
  const MapFactor& factor = map.factors().all()[0];
  EXPECT_EQ(factor.poses[0].keyframe, added.back());
  EXPECT_EQ(factor.poses[0].T_KB.Matrix(), T_FW.Matrix());
  EXPECT_NE(factor.frame, known) << "each has its own frames";
  EXPECT_FALSE(map.factors().frame(factor.frame).upright);
  const auto place = map.factors().T_FW(factor.frame, *map.RootOf(added.back()));
  ASSERT_TRUE(place);
  EXPECT_EQ(place->Matrix(), T_FW.Matrix());
  EXPECT_EQ(map.keyframe(added[2])->found, 0.625) << "the third that is left";
  EXPECT_EQ(map.keyframe(added[2])->depth_grid.size(), cv::Size(3, 2));
  EXPECT_EQ(map.Find(last_point.id)->observations.size(), last_point.observations.size());

  const KeyFrame &old = *other.keyframe(1_kf), &same = *map.keyframe(added[1]);
  EXPECT_EQ(same.T_WC.Matrix(), old.T_WC.Matrix());
  for (std::size_t f = 0; f < old.points.size(); ++f) {
    ASSERT_EQ(old.points[f] == kNoId, same.points[f] == kNoId);
    if (old.points[f] == kNoId) continue;
    const MapPoint &a = *other.Find(old.points[f]), &b = *map.Find(same.points[f]);
    EXPECT_EQ(a.p_W, b.p_W);
    EXPECT_EQ(a.descriptor, b.descriptor);
    EXPECT_EQ(a.observations.size(), b.observations.size());
    EXPECT_EQ(b.id, same.points[f]);
    EXPECT_EQ(b.patch, nullptr) << "it names a keyframe that has another number here";
  }
  EXPECT_EQ(map.index().size(), map.num_keyframes());
}

TEST(MergeMaps, RefusesMapsOfOtherPoints) {
  const auto message_of = [](const std::vector<FeatureType>& kinds) {
    std::vector<Map> maps;
    for (const FeatureType& kind : kinds) {
      maps.emplace_back();
      maps.back().AddKeyFrame({.features = std::make_shared<const FrameFeatures>()}, Pose());
      maps.back().SetFeatureType(kind);
    }
    return testing::MessageOf<InvalidArgument>([&] { MergeMaps({}, std::move(maps)); });
  };
  EXPECT_EQ(message_of({{.name = "sift"}, {.name = "orb"}}),
            "MergeMaps: the points of one map are by sift, those of another by orb");
  EXPECT_EQ(message_of({{.pyramid = {.levels = 4}}, {}}),
            "MergeMaps: the points of one map are by orb in 4 levels of 1.2, those of another by "
            "orb in 8 levels of 1.2");
  EXPECT_EQ(message_of({{}, {.pyramid = {.scale_factor = 1.25}}}),
            "MergeMaps: the points of one map are by orb in 8 levels of 1.2, those of another by "
            "orb in 8 levels of 1.25");
  EXPECT_EQ(message_of({{.name = "net", .columns = 64}, {.name = "net"}}),
            "MergeMaps: the points of one map are by net with descriptors of 64 bytes, those of "
            "another by net with descriptors of 32 bytes");
  EXPECT_EQ(message_of({{.name = "net", .descriptor = DescriptorType::kFloat}, {.name = "net"}}),
            "MergeMaps: the points of one map are by net with descriptors of 32 numbers, those of "
            "another by net with descriptors of 32 bytes");
}

}  // namespace
}  // namespace highwall::merge_maps_test
