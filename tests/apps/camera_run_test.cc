// Runs on a camera that a test implements.
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/input/live_camera.h>

#include "run/slam_run.h"
#include "simulate/scenes/room.h"
#include "support/message_of.h"
#include "support/small_room.h"

namespace highwall::camera_run_test {
namespace {

using apps::RunSlam;
using apps::SlamRun;
using apps::SlamRunOptions;

constexpr std::chrono::milliseconds kInterval(60);  // of a slow camera

// A camera in a generated room that delivers so many images and then ends, or fails.
class RoomCamera final : public ImageSource {
 public:
  RoomCamera(const simulate::Simulation& room, int images, bool fails = false)
      : room_(room), images_(images), fails_(fails) {
    calibration_.sensor.camera = room.options().camera;
  }

  std::optional<RgbdImage> Next() override {
    if (next_ == images_ && fails_) throw IoError("camera", "is unplugged");
    if (next_ == images_ || stopped_) return std::nullopt;
    std::this_thread::sleep_for(kInterval);
    const simulate::SimulatedFrame frame = room_.Render(next_++);
    return RgbdImage{.stamp = frame.stamp, .bgr = frame.bgr, .depth = frame.depth};
  }
  void Stop() override { stopped_ = true; }
  const SensorCalibration* calibration() const override { return &calibration_; }

 private:
  const simulate::Simulation& room_;
  const int images_;
  const bool fails_;
  SensorCalibration calibration_;
  int next_ = 0;
  std::atomic<bool> stopped_ = false;
};

SlamRun RunOn(RoomCamera& device, const apps::RunCallbacks& callbacks = {}) {
  LiveCamera camera(device, {.queue = 100});
  SlamRunOptions options;
  options.live = true;
  options.map.octree.resolution = 0.1;
  return RunSlam(camera, camera.calibration()->sensor, options, callbacks);
}

TEST(CameraRun, EndsWithTheCameraAndStatesTheDelayOfEachPose) {
  const simulate::Simulation room = simulate::SimulateRoom(testing::SmallRoomOptions());
  RoomCamera device(room, 8);
  const SlamRun run = RunOn(device);
  EXPECT_TRUE(run.failures.empty()) << run.failures.front();
  EXPECT_EQ(run.frames, 8U);
  EXPECT_EQ(run.skipped, 0U);
  EXPECT_EQ(run.largest.trajectory.size(), 8U);
  EXPECT_TRUE(run.is_of_camera);
  EXPECT_EQ(run.times.delay.count, 8U);
  EXPECT_GT(run.times.delay.median, 0.0);
  ASSERT_TRUE(run.largest.dense);
  EXPECT_GT(run.largest.dense->cloud.size(), 0U);
}

TEST(CameraRun, ACameraThatFailsLeavesTheResultsOfTheImagesBefore) {
  const simulate::Simulation room = simulate::SimulateRoom(testing::SmallRoomOptions());
  RoomCamera device(room, 5, true);
  const SlamRun run = RunOn(device);
  EXPECT_EQ(run.failures, std::vector<std::string>{"camera: is unplugged"});
  EXPECT_EQ(run.largest.trajectory.size(), 5U);
  EXPECT_TRUE(run.largest.dense);
  RoomCamera silent(room, 0, true);
  EXPECT_EQ(testing::MessageOf<IoError>([&] { RunOn(silent); }), "camera: is unplugged");
}

TEST(CameraRun, EndsWhenTheCameraIsStoppedFromAnotherThread) {
  const simulate::Simulation room = simulate::SimulateRoom(testing::SmallRoomOptions());
  RoomCamera device(room, 200);
  std::optional<std::jthread> stopper;
  const SlamRun run =
      RunOn(device,
            {.on_frame = [&](const FrameResult&, const RgbdImage&, std::size_t done, std::size_t) {
              if (done == 4) stopper.emplace([&] { device.Stop(); });
            }});
  EXPECT_GE(run.frames, 4U);
  EXPECT_LT(run.frames, 200U);
  EXPECT_EQ(run.largest.trajectory.size(), run.frames);
  EXPECT_TRUE(run.largest.dense);
}

}  // namespace
}  // namespace highwall::camera_run_test
