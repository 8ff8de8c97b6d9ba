#include "true_recording.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <fmt/core.h>

#include <highwall/core/error.h>

#include "run/imu_input.h"
#include "run/opened_dataset.h"
#include "scenes.h"

namespace highwall::bench {
namespace {

// Rendered once, for many runs.
class RenderedFrames final : public Dataset {
 public:
  explicit RenderedFrames(const simulate::Simulation& simulation) {
    for (int i = 0; i < simulation.size(); ++i) {
      simulate::SimulatedFrame frame = simulation.Render(i);
      images_.push_back({frame.stamp, frame.bgr, frame.depth});
      truth_.push_back({frame.stamp, frame.T_WC});
    }
  }

  std::size_t size() const override { return images_.size(); }
  Stamp stamp(std::size_t index) const override { return images_[index].stamp; }
  const Trajectory* groundtruth() const override { return &truth_; }

 private:
  RgbdImage DoLoad(std::size_t index) const override { return images_.at(index); }

  std::vector<RgbdImage> images_;
  Trajectory truth_;
};

// The first frames of another dataset.
class FirstFrames final : public Dataset {
 public:
  FirstFrames(std::unique_ptr<const Dataset> images, double seconds) : images_(std::move(images)) {
    const Stamp end = images_->stamp(0) + FromSeconds(seconds);
    while (size_ < images_->size() && images_->stamp(size_) <= end) ++size_;
  }

  std::size_t size() const override { return size_; }
  Stamp stamp(std::size_t index) const override { return images_->stamp(index); }
  Stamp depth_stamp(std::size_t index) const override { return images_->depth_stamp(index); }
  const Trajectory* groundtruth() const override { return images_->groundtruth(); }

 private:
  RgbdImage DoLoad(std::size_t index) const override {
    std::optional<RgbdImage> image = images_->Load(index);
    if (!image) throw IoError(fmt::format("frame {}", index), "cannot be used");
    return *std::move(image);
  }

  std::unique_ptr<const Dataset> images_;
  std::size_t size_ = 0;
};

simulate::SimulationOptions OptionsOf(const GeneratedRecording& recording) {
  simulate::SimulationOptions options =
      recording.scene == "room" ? SmallRoomOptions(recording.seed, recording.seconds)
                                : SmallFieldTestOptions(recording.seed, recording.seconds);
  options.fps = 30.0;
  options.depth_delay = recording.depth_delay;
  return options;
}

}  // namespace

TrueRecording Generate(const GeneratedRecording& recording) {
  const simulate::Simulation simulation = Simulate(recording.scene, OptionsOf(recording));
  RgbdSensor sensor{.camera = simulation.options().camera,
                    .depth_noise = simulation.options().sensor.Noise()};
  return {fmt::format("{} {}", recording.scene, recording.seed),
          std::make_shared<const RenderedFrames>(simulation), sensor,
          apps::ImuFeed{CalibrationOf(simulation.options().imu), simulation.ImuSamples()}};
}

TrueRecording OpenRecording(const std::filesystem::path& folder, double seconds) {
  apps::OpenedDataset opened = apps::OpenWithConfig("", folder);
  if (opened.images->groundtruth() == nullptr) {
    throw IoError(folder / "groundtruth.txt", "is missing or empty; errors need it");
  }
  std::optional<apps::ImuFeed> imu;
  if (const auto& calibration = opened.config.imu) {
    const std::optional<apps::ImuInput> input = apps::LoadImu(*opened.images, *calibration);
    if (input && input->IsUsable()) imu = apps::ImuFeed{input->calibration, input->samples};
  }
  const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
  return {(whole.has_filename() ? whole : whole.parent_path()).filename().string(),
          std::make_shared<const FirstFrames>(std::move(opened.images), seconds),
          opened.config.sensor, std::move(imu)};
}

}  // namespace highwall::bench
