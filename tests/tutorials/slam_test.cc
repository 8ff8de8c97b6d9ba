// The program of docs/tutorial_slam.md.
#include "examples/slam/follow.h"
#include "examples/slam/pilot.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <highwall/core/trajectory_error.h>
#include <simulate/scenes/room.h>

#include "simulate/output/tum_writer.h"
#include "support/rendered_walk.h"
#include "support/small_room.h"
#include "support/temporary_directory.h"

namespace highwall {
namespace {

using Clock = std::chrono::steady_clock;

// Duration of tracking on this machine: a much faster camera would lose its view.
Clock::duration TimeOfAFrame(const RgbdSensor& sensor, std::span<const RgbdImage> images) {
  constexpr std::size_t kFrames = 5;
  SlamSystem slam(sensor);
  const auto start = Clock::now();
  for (const RgbdImage& image : images.first(kFrames)) slam.Track(image);
  return (Clock::now() - start) / kFrames;
}

// Delivers these images, each after a pause.
class PacedCamera final : public ImageSource {
 public:
  PacedCamera(std::span<const RgbdImage> images, Clock::duration pause)
      : images_(images), pause_(pause) {}

  std::optional<RgbdImage> Next() override {
    if (next_ == images_.size()) return std::nullopt;
    std::this_thread::sleep_for(pause_);
    return images_[next_++];
  }
  void Stop() override {}

 private:
  const std::span<const RgbdImage> images_;
  const Clock::duration pause_;
  std::size_t next_ = 0;
};

TEST(SlamTutorial, FollowsACameraThatDoesNotWait) {
  simulate::SimulationOptions options;
  options.seed = 3;
  options.duration = 1.5;
  options.camera = {
      .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
  const testing::RenderedWalk walk = testing::Render(simulate::SimulateRoom(options));
  const std::vector<RgbdImage>& images = walk.images;

  const RgbdSensor sensor{.camera = options.camera};
  const auto pause =
      std::max<Clock::duration>(std::chrono::milliseconds(20), 2 * TimeOfAFrame(sensor, images));
  Pilot pilot(sensor);
  PacedCamera camera(images, pause);
  const std::size_t dropped = pilot.Run(camera);
  EXPECT_EQ(pilot.path().size() + dropped, images.size());
  ASSERT_TRUE(pilot.here());
  EXPECT_GE(pilot.places().size(), 1u);
  EXPECT_EQ(pilot.returns(), 0);
  EXPECT_LT(AbsolutePoseError(walk.truth, pilot.path()).statistics.rmse, 0.01);
}

TEST(SlamTutorial, FollowsARecording) {
  const testing::TemporaryDirectory folder;
  testing::WriteSmallRoom(folder.path(), 20);
  const Trajectory path = Follow(folder.path(), {.camera = testing::SmallRoomOptions().camera});
  EXPECT_EQ(path.size(), 20u);
  const Trajectory truth = ReadTumTrajectory(folder.path() / "groundtruth.txt");
  EXPECT_LT(AbsolutePoseError(truth, path).statistics.rmse, 0.01);
}

}  // namespace
}  // namespace highwall
