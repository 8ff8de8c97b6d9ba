#include <algorithm>

#include <gtest/gtest.h>

#include "support/id_literals.h"
#include "support/synthetic_scene.h"
#include "tracking/relocalizer.h"
#include "tracking/tracker_parameters.h"

namespace highwall::relocalizer_test {
namespace {

using testing::AngleError;
using testing::IdealSensor;
using testing::kStrictLines;
using testing::kStrictRule;
using testing::Look;
using testing::MakeScene;
using testing::PositionError;
using testing::Scene;
using testing::SceneMap;
using testing::SyntheticView;
using testing::operator""_kf;

// Four keyframes of one scene that look to the left, ahead and to the right.
const Pose kKeyFrames[] = {
    Pose::FromTangent({0, 0, 0}, {0, -0.6, 0}), Pose::FromTangent({0.2, 0, 0}, {0, -0.2, 0}),
    Pose::FromTangent({0, 0.1, 0}, {0, 0.2, 0}), Pose::FromTangent({-0.1, 0, 0.1}, {0, 0.6, 0})};
// The query pose is near the third of them.
const Pose kQuery = Pose::FromTangent({0.1, 0.05, 0.2}, {0.05, 0.3, 0.1});

class RelocalizerTest : public ::testing::Test {
 protected:
  RelocalizerTest() {
    for (const Pose& T_WC : kKeyFrames) {
      scene_map.Add(Look(scene, IdealSensor(), T_WC), T_WC);
    }
  }

  const Scene scene = MakeScene(5, 500, 0);
  const MeasurementModel model{IdealSensor(), {}};
  const Relocalizer relocalizer{model, {}};
  SceneMap scene_map{scene};
};

TEST_F(RelocalizerTest, FindsThePoseFromScratch) {
  const SyntheticView view = Look(scene, IdealSensor(), kQuery);
  const auto found = relocalizer.Relocalize(*view.features, scene_map.map);
  ASSERT_TRUE(found);
  EXPECT_LT(PositionError(found->T_WC, kQuery), 1e-9);  // exact features: rounding
  EXPECT_LT(AngleError(found->T_WC, kQuery), 1e-9);
  EXPECT_EQ(found->keyframe, 2_kf) << "it shares most";
  EXPECT_GT(found->matches.points.size(), 40u);
  for (const auto& [feature, id] : found->matches.points) {
    const int place = view.points[static_cast<std::size_t>(feature)];
    EXPECT_EQ(id, scene_map.point_ids[static_cast<std::size_t>(place)]);
  }
}

TEST_F(RelocalizerTest, SetsWrongLandmarksAside) {
  // Forty in a hundred landmarks are displaced.
  std::vector<bool> moved(scene_map.point_ids.size(), false);
  for (std::size_t i = 0; i < moved.size(); ++i) {
    MapPoint* point = scene_map.map.Find(scene_map.point_ids[i]);
    moved[i] = i % 5 < 2;
    if (point != nullptr && moved[i]) point->p_W += Eigen::Vector3d(0.4, -0.3, 0.5);
  }
  // With equal displacements they are consistent with another pose: the larger group wins.
  const SyntheticView view = Look(scene, IdealSensor(), kQuery, {.px = 0.7, .depth = true});
  const auto found = relocalizer.Relocalize(*view.features, scene_map.map);
  ASSERT_TRUE(found);
  // 1 px at 500 px and 3 m over some 60 points is a millimetre; the bound is ten times that.
  EXPECT_LT(PositionError(found->T_WC, kQuery), 0.01);
  EXPECT_LT(AngleError(found->T_WC, kQuery), 0.005);
  for (const auto& [feature, id] : found->matches.points) {
    EXPECT_FALSE(moved[static_cast<std::size_t>(view.points[static_cast<std::size_t>(feature)])]);
  }
}

// Most matches are wrong by metres, hundreds of sigma: too many for any robust cost. The few
// inliers that RANSAC found are enough.
TEST_F(RelocalizerTest, NeedsNoMoreThanRansacFound) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SceneMap shaken(scene);
    for (const Pose& T_WC : kKeyFrames) shaken.Add(Look(scene, IdealSensor(), T_WC), T_WC);
    std::mt19937 rng(seed);
    std::vector<bool> moved(scene.points.size());
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const Eigen::Vector3d step = testing::UniformInBox(rng, {-2, -2, -1}, {2, 2, 4});
      moved[i] = testing::Uniform(rng, 0.0, 1.0) < 0.7;
      MapPoint* point = shaken.map.Find(shaken.point_ids[i]);
      if (point != nullptr && moved[i]) point->p_W += step;
    }
    const SyntheticView view =
        Look(scene, IdealSensor(), kQuery, {.px = 0.7, .depth = true, .seed = seed});
    const auto found =
        Relocalizer(model, {.ransac_iterations = 1000}).Relocalize(*view.features, shaken.map);
    ASSERT_TRUE(found) << seed;
    EXPECT_LT(PositionError(found->T_WC, kQuery), 0.02) << seed;
    EXPECT_LT(AngleError(found->T_WC, kQuery), 0.01) << seed;
    int right = 0, wrong = 0;
    for (const auto& [feature, id] : found->matches.points) {
      const auto place = static_cast<std::size_t>(view.points[static_cast<std::size_t>(feature)]);
      ++(moved[place] ? wrong : right);
    }
    EXPECT_GE(right, 20) << seed;
    EXPECT_LE(wrong, 1) << seed;  // by chance a landmark may have moved along its ray
  }
}

// Views that overlap little share few landmarks. The tracker takes that of the keyframe where the
// camera was before, but not any place of the map.
TEST_F(RelocalizerTest, FewerLandmarksSufficeInTheReferenceKeyframe) {
  const TrackerParameters parameters;
  int found_right = 0, found_anywhere = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SceneMap shaken(scene);
    for (const Pose& T_WC : kKeyFrames) shaken.Add(Look(scene, IdealSensor(), T_WC), T_WC);
    const SyntheticView view =
        Look(scene, IdealSensor(), kQuery, {.px = 0.7, .depth = true, .seed = seed});
    std::vector<bool> stays(scene.points.size(), false);
    int kept = 0;  // of the landmarks in both views
    for (const int place : view.points) {
      const auto i = static_cast<std::size_t>(place);
      if (place < 0 || kept == 15) continue;
      const auto& seen = shaken.map.keyframe(2_kf)->points;
      if (std::find(seen.begin(), seen.end(), shaken.point_ids[i]) != seen.end()) {
        stays[i] = true;
        ++kept;
      }
    }
    for (std::size_t i = 0; i < stays.size(); ++i) {
      const PointId id = shaken.point_ids[i];
      if (shaken.map.Find(id) != nullptr && !stays[i]) shaken.map.Remove(id);
    }
    const auto match = [&](const RelocalizerOptions& options) {
      return Relocalizer(model, options)
          .MatchKeyFrame(*view.features, shaken.map, 2_kf, kKeyFrames[2]);
    };
    found_anywhere += match(parameters.relocalizer) ? 1 : 0;
    const auto found = match(parameters.reference);
    if (found && PositionError(found->T_WC, kQuery) < 0.05) ++found_right;
  }
  EXPECT_GE(found_right, 5);
  EXPECT_EQ(found_anywhere, 0);
}

// Corners of a blurred image are four times as uncertain as those of a sharp one.
TEST_F(RelocalizerTest, FindsAPlaceInABlurredImage) {
  int found = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const SyntheticView view =
        Look(scene, IdealSensor(), kQuery, {.px = 2.8, .depth = true, .seed = seed});
    const auto place = relocalizer.Relocalize(*view.features, scene_map.map);
    if (!place) continue;
    ++found;
    EXPECT_LT(PositionError(place->T_WC, kQuery), 0.05) << seed;
    EXPECT_LT(AngleError(place->T_WC, kQuery), 0.02) << seed;
  }
  EXPECT_EQ(found, 20);
}

// Another room with the same objects at other positions: displaced by up to half a metre, except
// for a dozen of them.
TEST_F(RelocalizerTest, RefusesASimilarRoom) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 rng(seed);
    Scene other = scene;
    for (std::size_t i = 0; i < other.points.size(); ++i) {
      const Eigen::Vector3d step = testing::UniformInBox(rng, {-.5, -.5, -.5}, {.5, .5, .5});
      if (i % 10 != 0) other.points[i].p_W += step;
    }
    const SyntheticView view = Look(other, IdealSensor(), kQuery, {.px = 0.7, .seed = seed});
    EXPECT_FALSE(relocalizer.Relocalize(*view.features, scene_map.map)) << seed;
  }
}

// A wall of a dozen different tiles in repetition, compared with another arrangement of them.
TEST(RelocalizerOnTiles, RefusesAnotherWallOfTheSameTiles) {
  const MeasurementModel model(IdealSensor(), {});
  const Relocalizer relocalizer(model, {});
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 rng(seed);
    std::vector<BinaryDescriptor256> tiles(12);
    for (BinaryDescriptor256& tile : tiles) tile = testing::RandomDescriptor(rng);
    const auto wall = [&] {
      Scene scene;
      for (int x = -8; x <= 8; ++x) {
        for (int y = -5; y <= 5; ++y) {
          // The tiles are not quite identical, otherwise no match would be clearly the best.
          BinaryDescriptor256 tile = tiles[rng() % tiles.size()];
          for (int bit = 0; bit < 12; ++bit) {
            tile[rng() % tile.size()] ^= static_cast<std::uint8_t>(1U << (rng() % 8));
          }
          scene.points.push_back({{0.25 * x, 0.25 * y, 3.0}, tile, 6.0});
        }
      }
      return scene;
    };
    const Scene known = wall(), other = wall();
    SceneMap scene_map(known);
    scene_map.Add(Look(known, IdealSensor(), Pose()), Pose());
    const SyntheticView view =
        Look(other, IdealSensor(), Pose::FromTangent({0.1, 0, 0}, {0, 0, 0}));
    EXPECT_FALSE(relocalizer.Relocalize(*view.features, scene_map.map)) << seed;
  }
}

TEST_F(RelocalizerTest, RefusesAForeignScene) {
  const Scene other = MakeScene(77, 500, 0);
  const SyntheticView view = Look(other, IdealSensor(), kQuery);
  EXPECT_FALSE(relocalizer.Relocalize(*view.features, scene_map.map));
}

TEST_F(RelocalizerTest, RefusesKnownDescriptorsInForeignPlaces) {
  Scene shuffled = scene;
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    shuffled.points[i].descriptor = scene.points[(i * 7 + 3) % scene.points.size()].descriptor;
  }
  const SyntheticView view = Look(shuffled, IdealSensor(), kQuery);
  EXPECT_FALSE(relocalizer.Relocalize(*view.features, scene_map.map));
}

TEST_F(RelocalizerTest, SameSeedGivesTheSameResult) {
  const SyntheticView view = Look(scene, IdealSensor(), kQuery, {.px = 1.0, .depth = true});
  const auto first = relocalizer.Relocalize(*view.features, scene_map.map);
  const auto second = Relocalizer(model, {}).Relocalize(*view.features, scene_map.map);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->T_WC.Matrix(), second->T_WC.Matrix());
  EXPECT_EQ(first->matches.points, second->matches.points);
}

TEST_F(RelocalizerTest, MatchesOneKeyFrameWithoutAVote) {
  const SyntheticView view = Look(scene, IdealSensor(), kQuery);
  const auto found = relocalizer.MatchKeyFrame(*view.features, scene_map.map, 1_kf, Pose());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->keyframe, 1_kf);
  EXPECT_LT(PositionError(found->T_WC, kQuery), 1e-9);
}

TEST_F(RelocalizerTest, NeedsDepthAndEnoughMatches) {
  const SyntheticView view = Look(scene, IdealSensor(), kQuery);
  auto flat = std::make_shared<FrameFeatures>(*view.features);
  for (PointFeature& point : flat->points) point.depth = 0.0;
  EXPECT_FALSE(relocalizer.Relocalize(*flat, scene_map.map));
  const Relocalizer many(model, {.min_matches = 1000});
  EXPECT_FALSE(many.Relocalize(*view.features, scene_map.map));
  const Relocalizer sure(model, {.min_inliers = 1000});
  EXPECT_FALSE(sure.Relocalize(*view.features, scene_map.map));
}

TEST(RelocalizerOnLines, CountWherePointsAreFew) {
  const Scene scene = MakeScene(8, 130, 150);
  const MeasurementModel model(IdealSensor(), {});
  SceneMap scene_map(scene);
  const SyntheticView keyframe = Look(scene, IdealSensor(), kKeyFrames[2]);
  scene_map.Add(keyframe, kKeyFrames[2]);
  const SyntheticView view = Look(scene, IdealSensor(), kQuery);
  auto points_only = std::make_shared<FrameFeatures>(*view.features);
  points_only->lines.clear();
  points_only->line_descriptors = cv::Mat();
  // The threshold is above the number of common points, but below the number with lines.
  const Relocalizer relocalizer(model, {.min_inliers = static_cast<int>(view.points.size()) + 1});
  EXPECT_FALSE(relocalizer.Relocalize(*points_only, scene_map.map));
  const auto found = relocalizer.Relocalize(*view.features, scene_map.map);
  ASSERT_TRUE(found);
  EXPECT_GT(found->matches.points.size(), 15u);
  EXPECT_GT(found->matches.lines.size(), 5u);
  EXPECT_LT(PositionError(found->T_WC, kQuery), 1e-6);  // float pixels of lines
}

TEST(RelocalizerOnLines, FindsThePoseFromAGuessNearby) {
  const Scene scene = MakeScene(6, 0, 120);
  const MeasurementModel model(IdealSensor(), {});
  const Relocalizer relocalizer(model, {});
  SceneMap scene_map(scene);
  scene_map.Add(Look(scene, IdealSensor(), kKeyFrames[1]), kKeyFrames[1]);
  scene_map.Add(Look(scene, IdealSensor(), kKeyFrames[3]), kKeyFrames[3]);
  const Pose truth = Pose::FromTangent({0.15, 0.05, 0}, {0.02, -0.15, 0.03});
  const SyntheticView view = Look(scene, IdealSensor(), truth);
  const auto found = relocalizer.Relocalize(*view.features, scene_map.map);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->keyframe, 0_kf);
  EXPECT_TRUE(found->matches.points.empty());
  EXPECT_GE(found->matches.lines.size(), 8u);
  for (const auto& [feature, id] : found->matches.lines) {
    const int place = view.lines[static_cast<std::size_t>(feature)];
    EXPECT_EQ(id, scene_map.line_ids[static_cast<std::size_t>(place)]);
  }
  // Float pixels, 3e-5 px at 525 px and 3 m.
  EXPECT_LT(PositionError(found->T_WC, truth), 1e-6);
  EXPECT_LT(AngleError(found->T_WC, truth), 1e-6);
  EXPECT_FALSE(
      Relocalizer(model, {.min_line_inliers = 1000}).Relocalize(*view.features, scene_map.map));
}

TEST(RelocalizerOnLines, TheirMatchesPassTheOutlierRuleOfTheModel) {
  const Scene scene = MakeScene(6, 0, 120);
  SceneMap scene_map(scene);
  scene_map.Add(Look(scene, IdealSensor(), kKeyFrames[1]), kKeyFrames[1]);
  const Pose truth = Pose::FromTangent({0.15, 0.05, 0}, {0.02, -0.15, 0.03});
  const SyntheticView view = Look(scene, IdealSensor(), truth);
  const MeasurementModel model(IdealSensor(), {});
  const MeasurementModel strict(IdealSensor(), kStrictRule, Pose(), {}, kStrictLines);
  EXPECT_TRUE(Relocalizer(model, {}).Relocalize(*view.features, scene_map.map));
  EXPECT_FALSE(Relocalizer(strict, {}).Relocalize(*view.features, scene_map.map));
}

TEST_F(RelocalizerTest, NothingFromNothing) {
  EXPECT_FALSE(relocalizer.Relocalize(FrameFeatures(), scene_map.map));
  EXPECT_FALSE(relocalizer.MatchKeyFrame(FrameFeatures(), scene_map.map, 0_kf, Pose()));
  const SyntheticView view = Look(scene, IdealSensor(), kQuery);
  EXPECT_FALSE(relocalizer.Relocalize(*view.features, Map()));
}

}  // namespace
}  // namespace highwall::relocalizer_test
