// SlamSystem with image sizes, fields of view and rates other than those of its development, in a
// rendered room: no constant in pixels or frames may suit only one of them.
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/trajectory_error.h>
#include <highwall/frontend/system/slam_system.h>
#include <simulate/scenes/room.h>

namespace highwall::slam_sizes_test {
namespace {

struct Images {
  const char* name;
  int width, height;  // [px]
  double focal;       // [px]
  double fps;         // [1/s]
};

PinholeCamera CameraOf(const Images& images) {
  return {.width = images.width,
          .height = images.height,
          .fx = images.focal,
          .fy = images.focal,
          .cx = 0.5 * (images.width - 1),
          .cy = 0.5 * (images.height - 1)};
}

class SlamSizesTest : public ::testing::TestWithParam<Images> {};

TEST_P(SlamSizesTest, LosesNoFrame) {
  simulate::SimulationOptions options;
  options.seed = 3;
  options.fps = GetParam().fps;
  options.duration = 2.5;
  options.camera = CameraOf(GetParam());
  options.sensor.noise = simulate::SensorNoise::kKinect;
  options.sensor.noise_ratio = 1.0;
  options.imu.enabled = false;
  const simulate::Simulation room = simulate::SimulateRoom(options);
  SlamSystem slam({.camera = options.camera}, Deterministic({}));
  Trajectory truth;
  int lost = 0;
  for (int i = 0; i < room.size(); ++i) {
    const simulate::SimulatedFrame frame = room.Render(i);
    const FrameResult result = slam.Track({frame.stamp, frame.bgr, frame.depth});
    lost += !HasPose(result.state);
    truth.push_back({frame.stamp, frame.T_WC});
  }
  EXPECT_EQ(lost, 0);
  EXPECT_EQ(slam.submaps().size(), 1U);
  // The bound is two pixels at 2.5 m, the distance of the walls.
  const double bound = 2.0 * 2.5 / GetParam().focal;
  EXPECT_LT(AbsolutePoseError(truth, slam.trajectory()).statistics.rmse, bound);
}

INSTANTIATE_TEST_SUITE_P(Images, SlamSizesTest,
                         ::testing::Values(Images{"QuarterAtFive", 320, 240, 262.5, 5.0},
                                           Images{"QuarterAtTen", 320, 240, 262.5, 10.0},
                                           Images{"QuarterAtNinety", 320, 240, 262.5, 90.0},
                                           Images{"SixteenthAtThirty", 160, 120, 131.25, 30.0},
                                           Images{"PortraitAtFifteen", 480, 640, 525.0, 15.0},
                                           Images{"SmallPortraitAtSixty", 192, 256, 213.0, 60.0},
                                           Images{"WideAngleAtFifteen", 320, 240, 160.0, 15.0},
                                           Images{"NarrowAngleAtThirty", 320, 240, 420.0, 30.0},
                                           Images{"FourfoldAtTen", 1280, 960, 1050.0, 10.0}),
                         [](const auto& images) { return std::string(images.param.name); });

}  // namespace
}  // namespace highwall::slam_sizes_test
