#include "abused_sequence.h"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>

namespace highwall::bench {
namespace {

// Returns the pose closest in time, the earlier of two; empty if none is within `tolerance`.
std::optional<Pose> NearestPose(const Trajectory& trajectory, Stamp stamp, Stamp tolerance) {
  const auto next = std::ranges::lower_bound(trajectory, stamp, {}, &StampedPose::stamp);
  std::optional<Pose> nearest;
  Stamp least = tolerance;
  if (next != trajectory.end() && next->stamp - stamp <= least) {
    nearest = next->pose;
    least = next->stamp - stamp;
  }
  if (next != trajectory.begin() && stamp - std::prev(next)->stamp <= least) {
    nearest = std::prev(next)->pose;
  }
  return nearest;
}

RgbdImage LoadOrThrow(const Dataset& dataset, std::size_t index) {
  std::optional<RgbdImage> image = dataset.Load(index);
  if (!image) throw IoError("frame " + std::to_string(index), "of the recording cannot be used");
  return *std::move(image);
}

}  // namespace

std::vector<AbusedFrame> FramesOf(const Dataset& dataset, std::size_t count) {
  std::vector<AbusedFrame> frames(std::min(count, dataset.size()));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i] = {&dataset, i, i, dataset.stamp(i), dataset.stamp(i)};
  }
  return frames;
}

AbusedSequence::AbusedSequence(std::vector<AbusedFrame> frames, const Abuse& abuse,
                               std::uint64_t seed)
    : home_(frames.at(0).images), change_(abuse.image), random_(seed) {
  // Separate streams, so that order and images use different numbers.
  frames_ = abuse.order ? abuse.order(std::move(frames), random_.Stream(0)) : std::move(frames);
  random_ = random_.Stream(1);
  HIGHWALL_REQUIRE(!frames_.empty(), abuse.name + " leaves no frame");
  const auto descends = [](Stamp a, Stamp b) { return a >= b; };
  HIGHWALL_REQUIRE(
      std::ranges::adjacent_find(frames_, descends, &AbusedFrame::stamp) == frames_.end(),
      abuse.name + ": stamps must ascend");
  if (const Trajectory* const groundtruth = home_->groundtruth()) FindGroundtruth(*groundtruth);
}

void AbusedSequence::FindGroundtruth(const Trajectory& groundtruth) {
  constexpr Stamp kTolerance = 20'000'000;  // [ns]
  groundtruth_.emplace();
  for (std::size_t i = 0; i < size(); ++i) {
    if (IsElsewhere(i)) continue;
    if (const auto pose = NearestPose(groundtruth, frames_[i].seen, kTolerance)) {
      groundtruth_->push_back({frames_[i].stamp, *pose});
    }
  }
}

RgbdImage AbusedSequence::DoLoad(std::size_t index) const {
  const AbusedFrame& frame = frames_[index];
  RgbdImage image = LoadOrThrow(*frame.images, frame.colour);
  if (frame.depth != frame.colour) image.depth = LoadOrThrow(*frame.images, frame.depth).depth;
  if (image.depth_stamp) *image.depth_stamp += frame.stamp - image.stamp;
  image.stamp = frame.stamp;
  if (!change_) return image;
  // The dataset may retain its images.
  image.bgr = image.bgr.clone();
  image.depth = image.depth.clone();
  change_(index, random_, &image);
  return image;
}

}  // namespace highwall::bench
