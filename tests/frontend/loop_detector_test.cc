#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "loops/loop_detector.h"
#include "support/id_literals.h"
#include "support/loop_scene.h"

namespace highwall::loop_detector_test {
namespace {

using testing::AngleError;
using testing::LoopScene;
using testing::PositionError;
using testing::operator""_kf;

class LoopDetectorTest : public ::testing::Test {
 protected:
  // Feeds the keyframes in the order of insertion; returns the first loop found.
  std::optional<Loop> Feed(LoopScene& scene, const LoopDetectorOptions& options = {},
                           const KeyFrameGraphOptions& graph = {}) {
    LoopDetector detector(scene.model, options, graph);
    for (int i = 0; i < scene.size(); ++i) {
      auto loop = detector.Detect(scene.map, scene.Add(i), {});
      if (loop) return loop;
    }
    return std::nullopt;
  }
  static std::optional<Loop> DetectLast(const LoopScene& scene,
                                        const LoopDetectorOptions& options = {},
                                        const KeyFrameGraphOptions& graph = {}) {
    const std::vector<KeyFrameId> keyframes = scene.map.keyframe_ids();
    LoopDetector detector(scene.model, options, graph);
    const auto loop = detector.DetectLast(scene.map, std::span(keyframes).last(3), {});
    EXPECT_LE(detector.TakeRefused().size(), loop ? 0u : 1u);
    return loop;
  }
  // Returns the true transform of the loop.
  static Pose Truth(const LoopScene& scene, const LoopEdge& edge) {
    return scene.truth[edge.match.index()].Inverse() * scene.truth[edge.keyframe.index()];
  }
  static inline const LoopDetectorOptions kNever{.consistency = 30};  // keyframes in a row
};

TEST_F(LoopDetectorTest, FindsTheReturnToTheStartInSpiteOfDrift) {
  LoopScene scene({.drift = {0.02, 0.0, 0.01}});
  const auto loop = Feed(scene);
  ASSERT_TRUE(loop);
  const Pose truth = Truth(scene, loop->edge);
  // 0.7 px over some 100 points at 3 m is about a millimetre; the landmarks of the place have
  // drifted relative to each other by centimetres.
  EXPECT_LT(PositionError(loop->edge.Z, truth), 0.03);
  EXPECT_LT(AngleError(loop->edge.Z, truth), 0.01);
  EXPECT_LT(loop->edge.match, 6_kf);
  EXPECT_GT(loop->edge.keyframe, 40_kf) << "only then the start comes into view";
  EXPECT_GT(loop->matches.points.size(), 30u);
  EXPECT_GT(loop->matches.lines.size(), 3u);
}

TEST_F(LoopDetectorTest, LinesPassTheOutlierRuleOfTheModel) {
  LoopScene scene({.drift = {0.02, 0.0, 0.01},
                   .measurement = testing::kStrictRule,
                   .matching = testing::kStrictLines});
  const auto loop = Feed(scene);
  ASSERT_TRUE(loop);
  EXPECT_GT(loop->matches.points.size(), 30u);
  EXPECT_LE(loop->matches.lines.size(), 2u);
}

TEST_F(LoopDetectorTest, LinesAloneAreEnough) {
  LoopScene scene({.points = 0, .lines = 1500, .drift = {0.005, 0.0, 0.0}});
  const auto loop = Feed(scene);
  ASSERT_TRUE(loop);
  EXPECT_TRUE(loop->matches.points.empty());
  const Pose truth = Truth(scene, loop->edge);
  EXPECT_LT(PositionError(loop->edge.Z, truth), 0.03);
}

TEST_F(LoopDetectorTest, OneKeyFrameIsNotEnoughEvidence) {
  LoopScene scene({});
  EXPECT_FALSE(Feed(scene, {.consistency = 30}));
}

TEST_F(LoopDetectorTest, WhereNoKeyFramesFollowOneThatMatchesWellIsEnough) {
  LoopScene scene({.drift = {0.005, 0.0, 0.0025}});
  EXPECT_FALSE(Feed(scene, kNever));
  const auto loop = DetectLast(scene);
  ASSERT_TRUE(loop);
  const Pose truth = Truth(scene, loop->edge);
  EXPECT_LT(PositionError(loop->edge.Z, truth), 0.03);
  EXPECT_LT(AngleError(loop->edge.Z, truth), 0.01);
}

TEST_F(LoopDetectorTest, WhereNoKeyFramesFollowOneThatMatchesHalfIsNotEnough) {
  LoopScene scene({.drift = {0.005, 0.0, 0.0025}, .strange_return = 0.5});
  EXPECT_FALSE(Feed(scene, kNever));
  for (const KeyFrameId id : scene.map.keyframe_ids()) scene.map.keyframe(id)->found = 0.95;
  EXPECT_FALSE(DetectLast(scene));
  EXPECT_TRUE(DetectLast(scene, {.min_found = 0.3, .min_match_ratio_across_submaps = 0.3}))
      << "it is the share";
}

TEST_F(LoopDetectorTest, WhereNoKeyFramesFollowOneBeyondAnyDriftIsNotEnough) {
  LoopScene scene({.drift = {0.0, 0.03, 0.0}});
  EXPECT_FALSE(Feed(scene, kNever));
  const KeyFrameGraphOptions strict{.drift_translation = 0.01, .loop_translation = 0.005};
  EXPECT_FALSE(DetectLast(scene, {}, strict));
  KeyFrameGraphOptions lax = strict;
  lax.max_loop_chi2 = 1e9;
  EXPECT_TRUE(DetectLast(scene, {}, lax)) << "it is the drift";
}

TEST_F(LoopDetectorTest, ATwinOfThePlaceBeyondAnyDriftIsRefused) {
  // The drift is ten centimetres of height a keyframe: the path returns five metres below its
  // start.
  LoopScene scene({.drift = {0.0, 0.1, 0.0}});
  EXPECT_FALSE(Feed(scene));
  LoopScene again({.drift = {0.0, 0.1, 0.0}});
  EXPECT_TRUE(Feed(again, {}, {.max_loop_chi2 = 1e9})) << "it is the gate that refuses";
}

TEST_F(LoopDetectorTest, TheSameLooksInOtherPlacesAreNoLoop) {
  // The descriptors change from keyframe 38 on, before the start comes into view.
  LoopScene scene({.shuffled_return = true});
  EXPECT_FALSE(Feed(scene));
}

TEST_F(LoopDetectorTest, ConnectedKeyFramesAreNoLoop) {
  LoopScene scene({.connected = true});
  EXPECT_FALSE(Feed(scene));
}

}  // namespace
}  // namespace highwall::loop_detector_test
