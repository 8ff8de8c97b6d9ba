// The program of docs/tutorial_slam.md, between the two marks, and its test.
// [tutorial]
#include <map>
#include <optional>

#include <highwall/frontend/input/live_camera.h>
#include <highwall/frontend/system/slam_system.h>

// Knows where the camera is, and where it has been.
class Pilot {
 public:
  // No camera waits for an adjustment.
  explicit Pilot(const highwall::RgbdSensor& sensor) : slam_(sensor, {.mapper = {.wait = false}}) {
    slam_.SetCallbacks(
        {.on_keyframe = [this](
                            const highwall::KeyFrame& keyframe,
                            const highwall::RgbdImage&) { places_[keyframe.id] = keyframe.T_WC; },
         .on_loop = [this](const highwall::LoopReport& loop) { returns_ += loop.accepted; },
         .on_map =
             [this](const highwall::Map& map) {
               for (auto& [id, T_WC] : places_) T_WC = map.ResolvePose(id);
             },
         .on_frame =
             [this](const highwall::FrameResult& frame) {
               here_.reset();
               if (HasPose(frame.state)) here_ = frame.T_WC;
             }});
  }

  // Until the camera is switched off. How many images came too fast is returned.
  std::size_t Run(highwall::ImageSource& device) {
    highwall::LiveCamera camera(device);
    while (const auto image = camera.Next()) slam_.Track(*image);
    slam_.Finish();
    return camera.dropped();
  }

  const std::optional<highwall::Pose>& here() const { return here_; }
  const std::map<highwall::KeyFrameId, highwall::Pose>& places() const { return places_; }
  highwall::Trajectory path() const { return slam_.trajectory(); }
  int returns() const { return returns_; }

 private:
  highwall::SlamSystem slam_;
  std::optional<highwall::Pose> here_;                     // T_WC, empty where lost
  std::map<highwall::KeyFrameId, highwall::Pose> places_;  // T_WC of keyframes
  int returns_ = 0;                                        // to places seen before
};
// [/tutorial]

// [tutorial]
#include <filesystem>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/open_dataset.h>

// A recording: nothing is dropped, however long a frame takes.
highwall::Trajectory Follow(const std::filesystem::path& folder,
                            const highwall::RgbdSensor& sensor) {
  const auto recording = highwall::OpenDataset(folder, sensor);
  highwall::SlamSystem slam(sensor);
  for (std::size_t i = 0; i < recording->size(); ++i) {
    if (const auto image = recording->Load(i)) slam.Track(*image);
  }
  slam.Finish();
  return slam.trajectory();
}
// [/tutorial]

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
