#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "map/map_matcher.h"
#include "support/id_literals.h"
#include "support/synthetic_scene.h"

namespace highwall::map_matcher_test {
namespace {

using testing::IdealSensor;
using testing::kLevels;
using testing::kScaleFactor;
using testing::Look;
using testing::MakeScene;
using testing::Scene;
using testing::SceneMap;
using testing::SyntheticView;
using testing::operator""_kf;

const Pose kPose = Pose::FromTangent({0.1, -0.05, 0.2}, {0.03, -0.08, 0.05});
// A motion of 2 cm and one degree: pixels move by some ten.
const Pose kNext = Pose::FromTangent({0.12, -0.05, 0.2}, {0.03, -0.06, 0.05});

class MapMatcherTest : public ::testing::Test {
 protected:
  MapMatcherTest() { scene_map.Add(view, kPose); }

  std::vector<bool> NoneOf(std::size_t count) const { return std::vector<bool>(count, false); }
  LandmarkMatches<MapPoint> MatchPoints(const SyntheticView& seen, const Pose& T_WC,
                                        std::vector<PointId>* visible = nullptr) const {
    return matcher.Match(*seen.features, T_WC, scene_map.map, scene_map.map.ids<MapPoint>(),
                         NoneOf(seen.points.size()), visible);
  }
  // Every match joins a feature with the landmark of the same index in the scene.
  void ExpectTrue(const LandmarkMatches<MapPoint>& matches, const SyntheticView& seen) const {
    for (const auto& [feature, id] : matches) {
      const int place = seen.points[static_cast<std::size_t>(feature)];
      EXPECT_EQ(id, scene_map.point_ids[static_cast<std::size_t>(place)]);
    }
  }

  const Scene scene = MakeScene(3, 400, 40);
  const MeasurementModel model{IdealSensor(), {}};
  const MapMatcher matcher{model};
  const SyntheticView view = Look(scene, IdealSensor(), kPose);
  SceneMap scene_map{scene};
};

TEST_F(MapMatcherTest, FindsEveryPointWhereItWasSeen) {
  std::vector<PointId> visible;
  const LandmarkMatches<MapPoint> matches = MatchPoints(view, kPose, &visible);
  ExpectTrue(matches, view);
  // In crowded windows a random descriptor may be similar (ratio test); here none is.
  EXPECT_EQ(matches.size(), view.points.size());
  EXPECT_EQ(visible, scene_map.map.ids<MapPoint>());
}

TEST_F(MapMatcherTest, FindsThePointsInViewFromTheNextPose) {
  const SyntheticView next = Look(scene, IdealSensor(), kNext);
  const LandmarkMatches<MapPoint> matches = MatchPoints(next, kNext);
  ExpectTrue(matches, next);
  int known = 0;
  for (const int place : next.points) {
    known += scene_map.point_ids[static_cast<std::size_t>(place)] != kNoId ? 1 : 0;
  }
  EXPECT_EQ(static_cast<int>(matches.size()), known);
}

TEST_F(MapMatcherTest, LeavesTakenFeaturesAlone) {
  std::vector<bool> taken(view.points.size(), false);
  taken[3] = taken[5] = true;
  const LandmarkMatches<MapPoint> matches =
      matcher.Match(*view.features, kPose, scene_map.map, scene_map.map.ids<MapPoint>(), taken);
  EXPECT_EQ(matches.size(), view.points.size() - 2);
  for (const auto& [feature, id] : matches) EXPECT_TRUE(feature != 3 && feature != 5);
}

TEST_F(MapMatcherTest, PredictsTheLevelFromTheDistance) {
  MapPoint point;
  point.max_distance = 4.0;
  EXPECT_EQ(matcher.PredictOctave(point, 4.0), 0);
  EXPECT_EQ(matcher.PredictOctave(point, 9.0), 0) << "clamped";
  // Between the distances of levels 2 and 3 the finer level is predicted.
  EXPECT_EQ(matcher.PredictOctave(point, 4.0 / std::pow(kScaleFactor, 2.5)), 3);
  EXPECT_EQ(matcher.PredictOctave(point, 0.1), kLevels - 1) << "clamped";
}

TEST_F(MapMatcherTest, PointsOutsideOfTheFrustumAreNotVisible) {
  MapPoint& point = *scene_map.map.Find(PointId(0));
  const auto is_visible = [&](const Eigen::Vector3d& p_C) {
    point.p_W = kPose * p_C;
    point.normal_W = (point.p_W - kPose.p()).normalized();
    point.min_distance = 0.001;
    point.max_distance = 100.0;
    std::vector<PointId> visible;
    MatchPoints(view, kPose, &visible);
    return std::find(visible.begin(), visible.end(), PointId(0)) != visible.end();
  };
  EXPECT_TRUE(is_visible({0, 0, 2}));
  EXPECT_FALSE(is_visible({0, 0, -2})) << "behind";
  EXPECT_FALSE(is_visible({0, 0, 0.04})) << "nearer than the domain of its residual";
  EXPECT_FALSE(is_visible({2, 0, 2})) << "right of the image";
  EXPECT_FALSE(is_visible({0, -2, 2})) << "above it";
}

TEST_F(MapMatcherTest, PointsOutOfScaleOrSeenFromBehindAreNotVisible) {
  MapPoint& point = *scene_map.map.Find(PointId(0));
  point.p_W = kPose * Eigen::Vector3d(0, 0, 2);
  const auto is_visible = [&](double min_distance, double max_distance, double cosine) {
    point.min_distance = min_distance;
    point.max_distance = max_distance;
    const double sine = std::sqrt(1.0 - cosine * cosine);
    point.normal_W = kPose.R() * Eigen::Vector3d(sine, 0, cosine);
    std::vector<PointId> visible;
    MatchPoints(view, kPose, &visible);
    return std::find(visible.begin(), visible.end(), PointId(0)) != visible.end();
  };
  EXPECT_TRUE(is_visible(1.0, 3.0, 1.0));
  // One level of tolerance on either side of 2 m.
  EXPECT_TRUE(is_visible(2.39, 9.0, 1.0));
  EXPECT_FALSE(is_visible(2.41, 9.0, 1.0));
  EXPECT_TRUE(is_visible(0.1, 1.67, 1.0));
  EXPECT_FALSE(is_visible(0.1, 1.66, 1.0));
  EXPECT_TRUE(is_visible(1.0, 3.0, 0.51));
  EXPECT_FALSE(is_visible(1.0, 3.0, 0.49)) << "min_view_cosine is 0.5";
}

TEST_F(MapMatcherTest, MatchesTheLandmarksOfTheLastFrame) {
  const SyntheticView next = Look(scene, IdealSensor(), kNext);
  const std::vector<PointId>& last_points = scene_map.map.keyframe(0_kf)->points;
  // The prediction is the previous pose: the window must cover the motion in the image, up to 20
  // px.
  const MeasurementModel wide_model(IdealSensor(), {.motion_radius = 30.0});
  const MapMatcher wide(wide_model);
  const LandmarkMatches<MapPoint> matches =
      wide.MatchLast(*next.features, kPose, scene_map.map, *view.features, last_points);
  ExpectTrue(matches, next);
  EXPECT_GT(matches.size(), next.points.size() * 8 / 10);
  const MeasurementModel narrow_model(IdealSensor(), {.motion_radius = 15.0});
  const MapMatcher narrow(narrow_model);
  EXPECT_EQ(
      narrow.MatchLast(*next.features, kPose, scene_map.map, *view.features, last_points, 2.0),
      matches)
      << "radius_scale";
}

TEST_F(MapMatcherTest, ForgottenAndUnmatchedLandmarksAreSkipped) {
  std::vector<PointId> last_points(view.points.size(), kNoId);
  EXPECT_TRUE(
      matcher.MatchLast(*view.features, kPose, scene_map.map, *view.features, last_points).empty());
  last_points[2] = scene_map.map.keyframe(0_kf)->points[2];
  last_points[4] = scene_map.map.keyframe(0_kf)->points[4];
  scene_map.map.Remove(last_points[4]);
  const LandmarkMatches<MapPoint> expected{{2, last_points[2]}};
  EXPECT_EQ(matcher.MatchLast(*view.features, kPose, scene_map.map, *view.features, last_points),
            expected);
  EXPECT_TRUE(matcher
                  .Match(*view.features, kPose, scene_map.map,
                         std::vector<PointId>{kNoId, PointId(9999)}, NoneOf(view.points.size()))
                  .empty());
}

TEST_F(MapMatcherTest, FindsTheLinesInView) {
  const SyntheticView next = Look(scene, IdealSensor(), kNext);
  std::vector<LineId> visible;
  const LandmarkMatches<MapLine> matches =
      matcher.Match(*next.features, kNext, scene_map.map, scene_map.map.ids<MapLine>(),
                    NoneOf(next.lines.size()), &visible);
  int known = 0;
  for (const int place : next.lines) {
    known += scene_map.line_ids[static_cast<std::size_t>(place)] != kNoId ? 1 : 0;
  }
  EXPECT_GT(known, 15);
  EXPECT_EQ(static_cast<int>(matches.size()), known);
  EXPECT_GE(visible.size(), matches.size());
  for (const auto& [feature, id] : matches) {
    const int place = next.lines[static_cast<std::size_t>(feature)];
    EXPECT_EQ(id, scene_map.line_ids[static_cast<std::size_t>(place)]);
  }
}

TEST_F(MapMatcherTest, LinesPassTheOutlierRuleOfTheModel) {
  const SyntheticView next = Look(scene, IdealSensor(), kNext);
  // The guess is slightly off, so that no two lines have the same displacement.
  const Pose guess = kNext * Pose::FromTangent({0.01, 0.0, 0.01}, {0.0, 0.0, 0.01});
  const auto matches = [&](const MeasurementOptions& options, const MatchingOptions& matching) {
    const MeasurementModel rule(IdealSensor(), options, Pose(), {}, matching);
    return MapMatcher(rule)
        .Match(*next.features, guess, scene_map.map, scene_map.map.ids<MapLine>(),
               NoneOf(next.lines.size()))
        .size();
  };
  EXPECT_GT(matches({}, {}), 15U);
  EXPECT_LE(matches(testing::kStrictRule, testing::kStrictLines), 2U);
}

TEST_F(MapMatcherTest, FindsLinesWithoutDescriptorsByTheirGates) {
  auto plain = std::make_shared<FrameFeatures>(*view.features);
  plain->line_descriptors = cv::Mat();
  const LandmarkMatches<MapLine> matches = matcher.Match(
      *plain, kPose, scene_map.map, scene_map.map.ids<MapLine>(), NoneOf(view.lines.size()));
  EXPECT_EQ(matches.size(), view.lines.size());
  for (const auto& [feature, id] : matches) {
    const int place = view.lines[static_cast<std::size_t>(feature)];
    EXPECT_EQ(id, scene_map.line_ids[static_cast<std::size_t>(place)]);
  }
}

TEST_F(MapMatcherTest, LinesTakenShortOrOutOfViewAreNotMatched) {
  std::vector<bool> taken(view.lines.size(), true);
  taken[1] = false;
  const auto lines = scene_map.map.ids<MapLine>();
  const LandmarkMatches<MapLine> one =
      matcher.Match(*view.features, kPose, scene_map.map, lines, taken);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].first, 1);

  MapLine& line = *scene_map.map.Find(one[0].second);
  const auto is_visible = [&](const Segment3& segment_C) {
    line.segment_W = kPose * segment_C;
    std::vector<LineId> visible;
    const LineId ids[] = {line.id};
    matcher.Match(*view.features, kPose, scene_map.map, ids, NoneOf(view.lines.size()), &visible);
    return !visible.empty();
  };
  EXPECT_TRUE(is_visible({{0, 0, 2}, {0.5, 0, 2}}));
  // 14 px and 16 px, for a minimum length of 15.
  EXPECT_FALSE(is_visible({{0, 0, 2}, {2.0 * 14.0 / 525.0, 0, 2}}));
  EXPECT_TRUE(is_visible({{0, 0, 2}, {2.0 * 16.0 / 525.0, 0, 2}}));
  EXPECT_FALSE(is_visible({{0, 0, -2}, {0.5, 0, -2}}));
}

TEST_F(MapMatcherTest, EmptyFeaturesMatchNothing) {
  const FrameFeatures empty;
  EXPECT_TRUE(
      matcher.Match(empty, kPose, scene_map.map, scene_map.map.ids<MapPoint>(), {}).empty());
  EXPECT_TRUE(matcher.Match(empty, kPose, scene_map.map, scene_map.map.ids<MapLine>(), {}).empty());
  EXPECT_TRUE(matcher
                  .MatchLast(empty, kPose, scene_map.map, *view.features,
                             scene_map.map.keyframe(0_kf)->points)
                  .empty());
}

}  // namespace
}  // namespace highwall::map_matcher_test
