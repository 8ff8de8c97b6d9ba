#include "parted_sequence.h"

#include <ranges>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/open_dataset.h>

#include "scenes.h"
#include "simulate/output/tum_writer.h"
#include "simulate/random.h"

namespace highwall::bench {
namespace {

simulate::PartedSimulation Simulate(const WalkOptions& options) {
  simulate::SimulationOptions simulation;
  simulation.seed = options.seed;
  simulation.fps = options.fps;
  simulation.camera = simulate::Scaled(simulation.camera, options.scale);
  simulation.imu.enabled = false;
  return options.twins ? simulate::SimulateTwinRooms(simulation)
                       : simulate::SimulateKidnap(simulation);
}

}  // namespace

WalkInParts::WalkInParts(const WalkOptions& options, const std::filesystem::path& cache,
                         const std::function<void(int, int)>& progress)
    : WalkInParts(options, cache, progress, Simulate(options)) {}

WalkInParts::WalkInParts(const WalkOptions& options, const std::filesystem::path& cache,
                         const std::function<void(int, int)>& progress,
                         simulate::PartedSimulation simulation)
    : parted_(std::move(simulation)),
      folder_(cache / fmt::format("{}_seed{}_{}fps_scale{}", options.twins ? "twins" : "kidnap",
                                  options.seed, options.fps, options.scale)) {
  if (!std::filesystem::exists(folder_)) {  // the folder is created atomically
    simulate::WriteTum(parted_.simulation, folder_, progress);
  }
  images_ = OpenDataset(folder_, sensor());
}

RgbdSensor WalkInParts::sensor() const {
  return {.camera = options().camera, .depth_noise = options().sensor.Noise()};
}

RgbdImage WalkInParts::Load(std::size_t frame) const {
  std::optional<RgbdImage> image = images_->Load(frame);
  if (!image) throw IoError(folder_, fmt::format("frame {} cannot be used", frame));
  return *std::move(image);
}

std::optional<int> WalkInParts::PartOf(std::size_t frame) const {
  return parted_.PartAt(ToSeconds(stamp(frame) - stamp(0)));
}

PartedSequence::PartedSequence(const WalkInParts& sequence, Ways ways)
    : sequence_(sequence), ways_(ways) {
  Stamp left_out = 0;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const std::optional<int> part = sequence.PartOf(i);
    if (!part && (ways == Ways::kLeftOut || ways == Ways::kNotNeeded)) {
      left_out += sequence.stamp(i) - sequence.stamp(i - 1);
      continue;
    }
    frames_.push_back({i, sequence.stamp(i) - left_out, part});
  }
  if (ways == Ways::kNotNeeded) PutInKnownOrder();
}

void PartedSequence::PutInKnownOrder() {
  std::vector<std::vector<PartedFrame>> parts;
  std::vector<Stamp> stamps;
  for (const PartedFrame& frame : frames_) {
    stamps.push_back(frame.stamp);
    parts.resize(static_cast<std::size_t>(*frame.part) + 1);
    parts.back().push_back(frame);
  }
  frames_.clear();
  const auto add = [this](const auto& part) {
    frames_.insert(frames_.end(), part.begin(), part.end());
  };
  switch (simulate::WayBackOf(sequence_.seed())) {
    case simulate::WayBack::kOnward:  // the second ends where the first begins,
      add(parts[1]);
      add(parts[0]);
      break;
    case simulate::WayBack::kReturn:  // or where it ends;
      add(parts[1]);
      add(std::ranges::reverse_view(parts[0]));
      break;
    case simulate::WayBack::kPutBack:  // the third begins in the first and ends in the second
      add(parts[0]);
      add(parts[2]);
      add(std::ranges::reverse_view(parts[1]));
      break;
  }
  for (std::size_t i = 0; i < stamps.size(); ++i) frames_[i].stamp = stamps[i];
}

RgbdImage PartedSequence::Load(const PartedFrame& frame) const {
  if (ways_ == Ways::kCovered && !frame.part) return Covered(frame);
  RgbdImage image = sequence_.Load(frame.source);
  if (image.depth_stamp) *image.depth_stamp += frame.stamp - image.stamp;
  image.stamp = frame.stamp;
  return image;
}

Trajectory PartedSequence::Truth() const {
  Trajectory truth;
  for (const PartedFrame& frame : frames_) {
    truth.push_back({frame.stamp, sequence_.T_WC(frame.source)});
  }
  return truth;
}

// Returns an almost black image with the noise of a sensor at the brightness of the room.
RgbdImage PartedSequence::Covered(const PartedFrame& frame) const {
  constexpr float kBlack = 4.0F, kNoise = 2.0F;  // [grey levels] mean and sigma
  constexpr float kHand = 0.25F;                 // [m] to a cover that is close
  constexpr int kBlob = 16;                      // [px] of connected garbage
  const PinholeCamera camera = sequence_.sensor().camera;
  RgbdImage image{frame.stamp, cv::Mat(camera.height, camera.width, CV_8UC3),
                  cv::Mat::zeros(camera.height, camera.width, CV_32FC1)};
  const auto random = simulate::CounterRandom(sequence_.seed()).Stream(frame.source);
  const auto guess = random.Stream(1);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto pixel = static_cast<std::uint64_t>(v * camera.width + u);
      const Eigen::Vector2f a = random.Normals(2 * pixel), b = random.Normals(2 * pixel + 1);
      image.bgr.at<cv::Vec3b>(v, u) =
          cv::Vec3f::all(kBlack) + kNoise * cv::Vec3f(a.x(), a.y(), b.x());
      const auto blob = static_cast<std::uint64_t>((v / kBlob) * camera.width + u / kBlob);
      if (cover() == Cover::kNear) image.depth.at<float>(v, u) = kHand + 0.003F * b.y();
      if (cover() == Cover::kGarbage && guess.Uniform(2 * blob) < 0.5F) {
        image.depth.at<float>(v, u) = 0.4F + 7.6F * guess.Uniform(2 * blob + 1);
      }
    }
  }
  return image;
}

}  // namespace highwall::bench
