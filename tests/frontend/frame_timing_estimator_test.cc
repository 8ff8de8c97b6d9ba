#include "sensor/frame_timing_estimator.h"

#include <memory>

#include <gtest/gtest.h>

#include "sensor/keyframe_row_times.h"
#include "support/synthetic_scene.h"

namespace highwall::frame_timing_estimator_test {
namespace {

// Returns the features of a wall that faces the camera, 2 m away.
std::shared_ptr<const FrameFeatures> Wall(const PinholeCamera& camera) {
  auto features = std::make_shared<FrameFeatures>();
  for (int v = 60; v <= 420; v += 60) {
    for (int u = 80; u <= 560; u += 60) {
      features->points.push_back({.uv = Eigen::Vector2d(u, v), .depth = 2.0, .depth_sigma = 0.01});
    }
  }
  features->depth_grid = cv::Mat(DepthGrid::SizeFor(camera), CV_32FC1, cv::Scalar(2.0));
  return features;
}

TEST(FrameTimingEstimator, StampsOfDepthDoNotCountAsDelayOfTheCamera) {
  const MeasurementModel model(testing::IdealSensor(), {});
  const PinholeCamera& camera = model.camera();
  const DepthGrid grid(camera);
  KeyframeRowTimes keyframes(camera, grid);
  FrameTimingEstimator estimator({}, model, grid, keyframes);
  const auto features = Wall(camera);
  constexpr double kLate = 0.01;  // [s] delay by the stamp, by which depth was moved
  Map map;
  KeyFrame& keyframe =
      map.AddKeyFrame({.index = 0, .stamp = 0, .features = features, .depth_delay = kLate}, Pose());
  std::vector<PointId> points;
  for (std::size_t i = 0; i < features->points.size(); ++i) {
    const PointId id =
        map.Add<MapPoint>(camera.Unproject(features->points[i].uv, features->points[i].depth), 0)
            .id;
    map.Observe(keyframe.id, static_cast<int>(i), id);
    points.push_back(id);
  }
  const Twist forward{.v = {0.0, 0.0, 0.5}}, back{.v = {0.0, 0.0, -0.5}};
  keyframes.Remember(keyframe, {{.depth_delay = kLate}, forward});
  // The measurements are consistent with the current timing.
  estimator.Add({FromSeconds(0.03), *features, points, Pose()}, map, back);
  const FrameTimingEstimate estimate = estimator.estimate();
  EXPECT_NEAR(estimate.value.depth_delay, 0.0, 1e-9);
  EXPECT_LT(estimate.sigma.depth_delay, 0.0099);  // and it is informative: 10 ms before
}

}  // namespace
}  // namespace highwall::frame_timing_estimator_test
