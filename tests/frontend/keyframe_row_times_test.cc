#include <algorithm>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "features/row_times.h"
#include "sensor/keyframe_row_times.h"
#include "support/synthetic_scene.h"

namespace highwall::keyframe_row_times_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeScene;
using testing::Scene;
using testing::SceneMap;
using testing::SyntheticView;

const Twist kMotion{.v = {0.5, -0.3, 0.2}, .omega = {0.6, 1.2, -0.4}};
constexpr FrameTiming kTiming{.colour_readout = 0.03, .depth_readout = 0.03};

// A keyframe that was made before the readout time of its rows was known.
class KeyframeRowTimesTest : public ::testing::Test {
 protected:
  KeyframeRowTimesTest() : scene_map_(scene_) {
    truth_ = Look(scene_, sensor_, T_WC_);
    SyntheticView seen = truth_;
    seen.features =
        CompensatedToMiddleRow(*truth_.features, sensor_.camera, -kTiming.colour_readout, kMotion);
    id_ = scene_map_.Add(seen, T_WC_);
    // The landmarks are placed where this keyframe has them.
    const KeyFrame& keyframe = *map().keyframe(id_);
    for (std::size_t i = 0; i < keyframe.points.size(); ++i) {
      const PointFeature& feature = keyframe.frame.features->points[i];
      map().Find(keyframe.points[i])->p_W =
          T_WC_ * sensor_.camera.Unproject(feature.uv, feature.depth);
    }
    times_.Remember(keyframe, {});
  }

  Map& map() { return scene_map_.map; }
  void Compensate(const FrameTimingEstimate& timing) {
    times_.Compensate(timing, map().KeyFramesOf(kFirstSubmap), &map());
  }
  const FrameFeatures& features() { return *map().keyframe(id_)->frame.features; }
  // Returns the error [m] of the landmark of point feature i.
  double Error(std::size_t i) {
    const Eigen::Vector3d& truth = scene_.points[static_cast<std::size_t>(truth_.points[i])].p_W;
    return (map().Find(map().keyframe(id_)->points[i])->p_W - truth).norm();
  }
  double LargestError() {
    double largest = 0.0;
    for (std::size_t i = 0; i < truth_.points.size(); ++i) largest = std::max(largest, Error(i));
    return largest;
  }

  const RgbdSensor sensor_ = IdealSensor();
  const DepthGrid grid_{sensor_.camera};
  const Scene scene_ = MakeScene(4, 200, 20);
  const Pose T_WC_ = Pose::FromTangent({0.1, 0.2, -0.3}, {0.05, -0.1, 0.02});
  SceneMap scene_map_;
  SyntheticView truth_;
  KeyFrameId id_ = kNoId;
  KeyframeRowTimes times_{sensor_.camera, grid_};
};

TEST_F(KeyframeRowTimesTest, FeaturesAndLandmarksFollowTheEstimatesOfTimingAndMotion) {
  const auto expected =
      CompensatedToMiddleRow(features(), sensor_.camera, kTiming.colour_readout, kMotion);
  const double before = LargestError();
  EXPECT_GT(before, 0.02);
  times_.Correct(id_, kMotion);
  Compensate({.value = kTiming});
  const KeyFrame& keyframe = *map().keyframe(id_);
  for (std::size_t i = 0; i < truth_.points.size(); ++i) {
    const PointFeature &now = features().points[i], &should = expected->points[i];
    EXPECT_LT((now.uv - should.uv).norm(), 1e-9) << i;  // rounding
    const Eigen::Vector3d p_W = T_WC_ * sensor_.camera.Unproject(should.uv, should.depth);
    EXPECT_LT((map().Find(keyframe.points[i])->p_W - p_W).norm(), 1e-12) << i;
  }
  // The row that a feature is moved to approximates the one it was seen in, 10 px of 480.
  EXPECT_LT(LargestError(), 0.1 * before);
  ASSERT_NE(times_.Find(id_), nullptr);
  EXPECT_EQ(times_.Find(id_)->timing.colour_readout, kTiming.colour_readout);
  EXPECT_EQ(times_.Find(id_)->motion.v, kMotion.v);
}

TEST_F(KeyframeRowTimesTest, LinesMoveAsTheirKeyframeSeesThem) {
  const KeyFrame& keyframe = *map().keyframe(id_);
  const auto before = keyframe.frame.features;
  const std::vector<LineId> lines = keyframe.lines;
  std::vector<Segment3> landmarks;
  for (const LineId id : lines) landmarks.push_back(map().Find(id)->segment_W);
  times_.Correct(id_, kMotion);
  Compensate({.value = kTiming});
  ASSERT_FALSE(lines.empty());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const SegmentDepth &from = *before->lines[i].segment_C, &to = *features().lines[i].segment_C;
    const Eigen::Vector3d shift =
        T_WC_.q() * (0.5 * (to.p_C + to.q_C) - 0.5 * (from.p_C + from.q_C));
    const Segment3& now = map().Find(lines[i])->segment_W;
    EXPECT_LT((now.p() - landmarks[i].p() - shift).norm(), 1e-12);
    EXPECT_LT((now.q() - landmarks[i].q() - shift).norm(), 1e-12);
  }
}

TEST_F(KeyframeRowTimesTest, ALandmarkFollowsByTheShareOfItsKeyframes) {
  const KeyFrame& keyframe = *map().keyframe(id_);
  const PointId point = keyframe.points[0];
  // A keyframe of another run, whose rows cannot be corrected.
  const Pose elsewhere = T_WC_ * Pose::FromTangent({0.02, 0.0, 0.0}, Eigen::Vector3d::Zero());
  const KeyFrameId other = scene_map_.Add(Look(scene_, sensor_, elsewhere), elsewhere);
  ASSERT_EQ(map().Find(point)->observations.size(), 2U);
  const Eigen::Vector3d before = map().Find(point)->p_W;
  const auto kept = map().keyframe(other)->frame.features;
  const PointFeature from = features().points[0];
  times_.Correct(id_, kMotion);
  Compensate({.value = kTiming});
  const PointFeature& to = features().points[0];
  const Eigen::Vector3d shift = T_WC_.q() * (sensor_.camera.Unproject(to.uv, to.depth) -
                                             sensor_.camera.Unproject(from.uv, from.depth));
  EXPECT_LT((map().Find(point)->p_W - before - 0.5 * shift).norm(), 1e-12);
  EXPECT_EQ(map().keyframe(other)->frame.features, kept);
}

TEST_F(KeyframeRowTimesTest, IgnoresChangesOfLessThanATenthOfAPixel) {
  const auto before = map().keyframe(id_)->frame.features;
  times_.Correct(id_, kMotion);
  Compensate({.value = {.colour_readout = 1e-5, .depth_readout = 1e-5}});
  EXPECT_EQ(map().keyframe(id_)->frame.features, before);
}

TEST_F(KeyframeRowTimesTest, AnEstimateWithinItsOwnSigmaMovesNothing) {
  const auto before = map().keyframe(id_)->frame.features;
  const std::vector<PointId> points = map().keyframe(id_)->points;
  const Eigen::Vector3d p_W = map().Find(points[0])->p_W;
  times_.Remember(*map().keyframe(id_), {FrameTiming(), kMotion});
  const FrameTiming sigma{.colour_readout = 0.031, .depth_readout = 0.031, .depth_delay = 0.01};
  Compensate({.value = kTiming, .sigma = sigma});
  EXPECT_EQ(map().keyframe(id_)->frame.features, before);
  EXPECT_EQ(map().Find(points[0])->p_W, p_W);
  // If the change exceeds the sigma of one of the three, the whole correction is applied.
  Compensate({.value = kTiming, .sigma = {.colour_readout = 0.029, .depth_readout = 0.031}});
  EXPECT_NE(map().keyframe(id_)->frame.features, before);
  EXPECT_EQ(times_.Find(id_)->timing.depth_readout, kTiming.depth_readout);
}

// However large the map is, its landmarks stay with their keyframes, which no adjustment moves.
TEST_F(KeyframeRowTimesTest, KeyframesThatNoAdjustmentMovesStayAsTheyAre) {
  const Pose elsewhere = T_WC_ * Pose::FromTangent({0.02, 0.0, 0.0}, Eigen::Vector3d::Zero());
  const KeyFrameId other = scene_map_.Add(Look(scene_, sensor_, elsewhere), elsewhere);
  times_.Remember(*map().keyframe(other), {FrameTiming(), kMotion});
  times_.Correct(id_, kMotion);
  const auto kept = map().keyframe(id_)->frame.features;
  const auto moved = map().keyframe(other)->frame.features;
  const std::vector<KeyFrameId> adjusted{other};
  times_.Compensate({.value = kTiming}, adjusted, &map());
  EXPECT_EQ(map().keyframe(id_)->frame.features, kept);
  EXPECT_EQ(times_.Find(id_)->timing.colour_readout, 0.0);
  EXPECT_NE(map().keyframe(other)->frame.features, moved);
  EXPECT_EQ(times_.Find(other)->timing.colour_readout, kTiming.colour_readout);
}

TEST_F(KeyframeRowTimesTest, KeyframesThatWereRemovedAreForgotten) {
  constexpr int kMade = 8;
  std::vector<KeyFrameId> made{id_};
  for (int i = 1; i < kMade; ++i) {
    made.push_back(scene_map_.Add(truth_, T_WC_));
    times_.Remember(*map().keyframe(made.back()), {});
  }
  const std::vector<KeyFrameId> removed(made.begin(), made.end() - 1);
  for (const KeyFrameId id : removed) map().RemoveKeyFrame(id, made.back());
  Compensate({.value = kTiming});
  for (const KeyFrameId id : removed) EXPECT_EQ(times_.Find(id), nullptr) << id;
  EXPECT_NE(times_.Find(made.back()), nullptr);
}

}  // namespace
}  // namespace highwall::keyframe_row_times_test
