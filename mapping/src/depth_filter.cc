#include <highwall/mapping/depth_filter.h>

#include <algorithm>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/mapping/keyframe_cloud.h>

namespace highwall {

DepthFilter::DepthFilter(const DepthCamera& camera, double voxel_size)
    : camera_(camera),
      smoothing_{.target_sigma = 0.25 * voxel_size, .max_extent = 2.0 * voxel_size},
      unprojector_(camera.pinhole) {
  HIGHWALL_REQUIRE(camera.sigma != nullptr, "DepthCamera::sigma must not be empty");
}

std::optional<KeyframeImage> DepthFilter::Push(KeyframeImage next) {
  unprojector_.RequireDepth(next.depth);
  next.depth =
      SmoothDepth(next.depth, camera_.pinhole.fx, camera_.sigma, smoothing_, next.noise_factor);
  held_.push_back({std::move(next)});
  std::optional<KeyframeImage> out = TakeOut(1);
  if (held_.size() > 2) held_.pop_front();
  return out;
}

std::optional<KeyframeImage> DepthFilter::Flush() {
  std::optional<KeyframeImage> out = TakeOut(0);
  held_.clear();
  return out;
}

std::size_t DepthFilter::MemoryBytes() const {
  const auto bytes_of = [](const cv::Mat& mat) {
    return mat.empty() ? 0 : mat.total() * mat.elemSize();
  };
  std::size_t bytes = 0;
  for (const Held& held : held_) {
    const KeyframeImage& frame = held.frame;
    bytes += bytes_of(frame.depth) + bytes_of(frame.bgr) + bytes_of(frame.noise_factor);
  }
  return bytes;
}

std::optional<KeyframeImage> DepthFilter::TakeOut(std::size_t newer) {
  if (held_.size() <= newer) return std::nullopt;
  const std::size_t here = held_.size() - 1 - newer;
  if (held_[here].done) return std::nullopt;
  held_[here].done = true;
  KeyframeImage out = held_[here].frame;
  std::vector<DepthView> neighbours;
  for (std::size_t i = 0; i < held_.size(); ++i) {
    const KeyframeImage& other = held_[i].frame;
    if (i != here && other.layer == out.layer) neighbours.push_back({other.depth, other.T_WC});
  }
  out.depth = KeepAgreedDepth({out.depth, out.T_WC}, neighbours, camera_.pinhole, unprojector_);
  return out;
}

void DepthFilter::Remove(std::int64_t id) {
  std::erase_if(held_, [&](const Held& held) { return held.frame.id == id; });
}

void DepthFilter::SetPoses(const std::map<std::int64_t, KeyframePose>& poses) {
  std::erase_if(held_, [&](const Held& held) { return !poses.contains(held.frame.id); });
  for (Held& held : held_) {
    const KeyframePose& now = poses.at(held.frame.id);
    held.frame.T_WC = now.T_WC;
    held.frame.layer = now.layer;
  }
}

}  // namespace highwall
