#include "depth_filter.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace highwall::apps {

DepthFilter::DepthFilter(const RgbdSensor& sensor, double voxel_size)
    : sensor_(sensor),
      smoothing_{.target_sigma = 0.25 * voxel_size, .max_extent = 2.0 * voxel_size},
      unprojector_(sensor.camera) {}

std::optional<PosedImage> DepthFilter::Push(PosedImage next) {
  const DepthNoise& noise = sensor_.depth_noise;
  next.image.depth = SmoothDepth(
      next.image.depth, sensor_.camera.fx, [&](double z) { return noise.Sigma(z); }, smoothing_);
  held_.push_back({std::move(next)});
  std::optional<PosedImage> out = TakeOut(1);
  if (held_.size() > 2) held_.pop_front();
  return out;
}

std::optional<PosedImage> DepthFilter::Flush() {
  std::optional<PosedImage> out = TakeOut(0);
  held_.clear();
  return out;
}

std::optional<PosedImage> DepthFilter::TakeOut(std::size_t newer) {
  if (held_.size() <= newer) return std::nullopt;
  const std::size_t here = held_.size() - 1 - newer;
  if (held_[here].done) return std::nullopt;
  held_[here].done = true;
  std::vector<DepthView> neighbours;
  for (std::size_t i = 0; i < held_.size(); ++i) {
    if (i != here) neighbours.push_back({held_[i].frame.image.depth, held_[i].frame.T_WC});
  }
  PosedImage out = held_[here].frame;
  out.image.depth =
      KeepAgreedDepth({out.image.depth, out.T_WC}, neighbours, sensor_.camera, unprojector_);
  return out;
}

void DepthFilter::Remove(std::int64_t id) {
  std::erase_if(held_, [&](const Held& held) { return held.frame.id == id; });
}

void DepthFilter::SetPose(std::int64_t id, const Pose& T_WC) {
  const auto held = std::ranges::find(held_, id, [](const Held& h) { return h.frame.id; });
  if (held != held_.end()) held->frame.T_WC = T_WC;
}

}  // namespace highwall::apps
