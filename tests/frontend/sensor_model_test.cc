#include "sensor/sensor_model.h"

#include <cstddef>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/frontend/tracking/options.h>

#include "support/synthetic_scene.h"
#include "tracking/tracker.h"

namespace highwall::sensor_model_test {
namespace {

using testing::IdealSensor;
using testing::Look;
using testing::MakeFrame;
using testing::MakeScene;
using testing::Scene;
using testing::SceneMap;

class SensorModelTest : public ::testing::Test {
 protected:
  SensorModelTest() : scene_map_(scene_), view_(Look(scene_, IdealSensor(), Pose())) {}

  const MeasurementModel model_{IdealSensor(), {}};
  const Scene scene_ = MakeScene(15, 100, 10);
  SceneMap scene_map_;
  const testing::SyntheticView view_;
  const Twist motion_{.v = {0.5, -0.3, 0.2}, .omega = {0.6, 1.2, -0.4}};
};

TEST_F(SensorModelTest, FeaturesAreTheSameOnesUnlessTheNoiseIsEstimated) {
  EXPECT_EQ(SensorModel(model_, {.estimates_noise = false}).WithNoise(view_.features),
            view_.features);
  EXPECT_NE(SensorModel(model_, {}).WithNoise(view_.features), view_.features);
  const MeasurementModel paper(IdealSensor(), {.weighting = Weighting::kPaper});
  EXPECT_EQ(SensorModel(paper, {}).WithNoise(view_.features), view_.features);
}

TEST_F(SensorModelTest, AllKeyframesOfAYoungMapGetTheNewNoise) {
  SensorModel sensor(model_, {});
  auto features = std::make_shared<FrameFeatures>(*view_.features);
  for (std::size_t i = 0; i < features->points.size(); i += 2) features->points[i].refined = true;
  testing::SyntheticView view = view_;
  view.features = features;
  for (int i = 0; i < 4; ++i) scene_map_.Add(view, Pose());
  Map& map = scene_map_.map;
  const std::vector<KeyFrameId> ids = map.keyframe_ids();
  sensor.LearnNoise(ids, kNoId, &map);
  const NoiseEstimate& noise = sensor.noise();
  // The scene has no noise: what residuals show is far less than the a priori noise of 1.
  EXPECT_LT(noise.point_px[0], 0.9);
  EXPECT_NE(noise.point_px[0], noise.refined_px[0]);
  for (const KeyFrameId id : ids) {
    const FrameFeatures& now = *map.keyframe(id)->frame.features;
    for (const PointFeature& point : now.points) {
      const auto octave = static_cast<std::size_t>(point.octave);
      EXPECT_EQ(point.noise.px, static_cast<float>(noise.point_px[octave])) << "refined or not";
      EXPECT_EQ(point.refined_noise_px, static_cast<float>(noise.refined_px[octave]));
      EXPECT_NE(point.noise.depth, 1.0F);
    }
    for (const LineFeature& line : now.lines) EXPECT_NE(line.noise.px, 1.0F);
  }
}

TEST_F(SensorModelTest, OtherKeyframesKeepTheirNoise) {
  for (int i = 0; i < 4; ++i) scene_map_.Add(view_, Pose());
  Map& map = scene_map_.map;
  std::vector<KeyFrameId> ids = map.keyframe_ids();
  const auto stays = [&](SensorModel&& sensor, KeyFrameId given, KeyFrameId id) {
    const auto before = map.keyframe(id)->frame.features;
    sensor.LearnNoise(ids, given, &map);
    return map.keyframe(id)->frame.features == before;
  };
  EXPECT_TRUE(stays({model_, {.estimates_noise = false}}, kNoId, ids[0]));
  const MeasurementModel paper(IdealSensor(), {.weighting = Weighting::kPaper});
  EXPECT_TRUE(stays({paper, {}}, kNoId, ids[0]));
  EXPECT_TRUE(stays({model_, {}}, ids[2], ids[2])) << "it was given with the map";
  EXPECT_FALSE(stays({model_, {}}, ids[2], ids[3]));
  while (map.num_keyframes() <= 10) scene_map_.Add(view_, Pose());
  ids = map.keyframe_ids();
  EXPECT_TRUE(stays({model_, {}}, kNoId, ids[0])) << "the map is no longer young";
}

TEST_F(SensorModelTest, TheDelayOfADepthImageIsAddedToTheTiming) {
  Frame frame = MakeFrame(view_, 0);
  EXPECT_FALSE(SensorModel(model_, {}).TimingOf(frame).has_value());
  frame.depth_delay = 0.004;
  const SensorModel sensor(model_, {}, {.colour_readout = 0.02, .depth_delay = 0.003});
  const auto timing = sensor.TimingOf(frame);
  ASSERT_TRUE(timing.has_value());
  EXPECT_EQ(timing->colour_readout, 0.02);
  EXPECT_DOUBLE_EQ(timing->depth_delay, 0.007);
  EXPECT_EQ(sensor.timing().depth_delay, 0.003);
}

TEST_F(SensorModelTest, AGlobalShutterHasNoTimingAndItsKeyframesStay) {
  SensorModel sensor(model_, {.has_row_times = false, .estimates_timing = false},
                     {.colour_readout = 0.02});
  EXPECT_FALSE(sensor.TimingOf(MakeFrame(view_, 0)).has_value());
  KeyFrame& keyframe = *scene_map_.map.keyframe(scene_map_.Add(view_, Pose()));
  sensor.Remember(keyframe, {{}, motion_});
  EXPECT_EQ(sensor.RowsOf(keyframe.id), nullptr);
  const auto before = keyframe.frame.features;
  sensor.CompensateAll(&scene_map_.map);
  EXPECT_EQ(keyframe.frame.features, before);
}

// The compensation of a keyframe was without motion, until the next frame shows that it moved.
TEST_F(SensorModelTest, ABetterMotionOfAKeyframeMovesItsFeatures) {
  const FrameTiming timing{.colour_readout = 0.02};
  SensorModel sensor(model_, {.estimates_timing = false}, timing);
  KeyFrame& keyframe = *scene_map_.map.keyframe(scene_map_.Add(view_, Pose()));
  sensor.Remember(keyframe, {timing, Twist()});
  ASSERT_NE(sensor.RowsOf(keyframe.id), nullptr);
  const auto before = keyframe.frame.features;
  sensor.CompensateAround(keyframe, 1, &scene_map_.map);
  EXPECT_EQ(keyframe.frame.features, before);
  const Frame next = MakeFrame(view_, 1);
  sensor.LearnTiming({next.stamp, *next.features, keyframe.points, Pose()}, scene_map_.map,
                     {.at_frame = motion_, .keyframe = keyframe.id, .at_keyframe = motion_});
  EXPECT_EQ(keyframe.frame.features, before);
  sensor.CompensateAround(keyframe, 1, &scene_map_.map);
  EXPECT_NE(keyframe.frame.features, before);
  EXPECT_EQ(sensor.RowsOf(keyframe.id)->motion.v, motion_.v);
  EXPECT_EQ(sensor.timing().colour_readout, 0.02);
}

TEST_F(SensorModelTest, AMotionByReadingsCountsUntilItIsForgotten) {
  const FrameTiming timing{.colour_readout = 0.02};
  SensorModel sensor(model_, {.estimates_timing = false}, timing);
  KeyFrame& keyframe = *scene_map_.map.keyframe(scene_map_.Add(view_, Pose()));
  sensor.Remember(keyframe, {timing, Twist()});
  sensor.CorrectMotion(keyframe.id, motion_);
  sensor.CompensateAll(&scene_map_.map);
  EXPECT_EQ(sensor.RowsOf(keyframe.id)->motion.v, motion_.v);
  sensor.ForgetReadings();
  sensor.CompensateAll(&scene_map_.map);
  EXPECT_EQ(sensor.RowsOf(keyframe.id)->motion.v, Eigen::Vector3d::Zero());
}

TEST(SensorOptions, FollowThoseOfTheTracker) {
  EXPECT_TRUE(SensorOptions({}).estimates_timing);
  EXPECT_TRUE(SensorOptions({}).estimates_noise);
  const SensorModelOptions known = SensorOptions({.timing = FrameTimingMode::kKnown});
  EXPECT_TRUE(known.has_row_times);
  EXPECT_FALSE(known.estimates_timing);
  EXPECT_FALSE(SensorOptions({.timing = FrameTimingMode::kIgnored}).has_row_times);
  EXPECT_FALSE(SensorOptions({.learn_noise = false}).estimates_noise);
}

}  // namespace
}  // namespace highwall::sensor_model_test
