#include "stated_recording.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>

namespace highwall::bench {
namespace {

RgbdImage LoadTrue(const TrueRecording& recording, std::size_t index) {
  std::optional<RgbdImage> image = recording.images->Load(index);
  if (!image) throw IoError(recording.name, "frame " + std::to_string(index) + " cannot be used");
  return *std::move(image);
}

}  // namespace

StatedRecording TruthOf(const TrueRecording& recording) {
  StatedRecording stated{.sensor = recording.sensor, .imu = recording.imu, .frames = {}};
  for (std::size_t i = 0; i < recording.images->size(); ++i) {
    stated.frames.push_back({i, i, recording.images->stamp(i)});
  }
  return stated;
}

StatedSequence::StatedSequence(const TrueRecording& recording, StatedRecording stated)
    : recording_(recording), stated_(std::move(stated)) {
  HIGHWALL_REQUIRE(!stated_.frames.empty(), "a recording must have a frame");
}

Stamp StatedSequence::depth_stamp(std::size_t index) const {
  const StatedFrame& frame = stated_.frames[index];
  const Dataset& images = *recording_.images;
  const Stamp delay = frame.depth == frame.colour
                          ? images.depth_stamp(frame.colour) - images.stamp(frame.colour)
                          : 0;
  return frame.stamp + delay + frame.depth_delay;
}

RgbdImage StatedSequence::DoLoad(std::size_t index) const {
  const StatedFrame& frame = stated_.frames[index];
  RgbdImage image = LoadTrue(recording_, frame.colour);
  if (frame.depth != frame.colour) image.depth = LoadTrue(recording_, frame.depth).depth;
  if (stated_.change_colour) {
    image.bgr = image.bgr.clone();  // the dataset retains its images
    stated_.change_colour(&image.bgr);
  }
  image.stamp = frame.stamp;
  image.depth_stamp = depth_stamp(index);
  const double true_factor = recording_.sensor.depth_factor;
  const RgbdSensor& sensor = stated_.sensor;
  if (!stated_.change_depth) {
    if (sensor.depth_factor == true_factor) return image;
    cv::Mat scaled;  // the dataset retains its images
    image.depth.convertTo(scaled, CV_32FC1, true_factor / sensor.depth_factor);
    image.depth = scaled;
    return image;
  }
  cv::Mat stored;
  image.depth.convertTo(stored, CV_16UC1, true_factor);
  stated_.change_depth(index, &stored);
  image.depth = MetricDepth(stored, sensor.depth_factor);
  return image;
}

Trajectory StatedSequence::AtTrueStamps(const Trajectory& trajectory) const {
  std::map<Stamp, Stamp> true_stamps;
  for (const StatedFrame& frame : stated_.frames) {
    true_stamps.emplace(frame.stamp, recording_.images->stamp(frame.colour));
  }
  Trajectory restored;
  for (const StampedPose& pose : trajectory) {
    restored.push_back({true_stamps.at(pose.stamp), pose.pose});
  }
  std::ranges::sort(restored, {}, &StampedPose::stamp);
  return restored;
}

}  // namespace highwall::bench
