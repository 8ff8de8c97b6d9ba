#include <highwall/mapping/dense_cloud.h>

#include <cmath>
#include <string>
#include <utility>

#include <highwall/core/error.h>

#include "voxel_filter.h"

namespace highwall {
namespace {

// True where one of the four neighbours that were measured lies off by more than `fraction` of z.
bool IsDepthEdge(const cv::Mat& depth, int u, int v, float fraction) {
  const float z = depth.at<float>(v, u);
  const auto differs = [&](int du, int dv) {
    const int nu = u + du, nv = v + dv;
    if (nu < 0 || nv < 0 || nu >= depth.cols || nv >= depth.rows) return false;
    const float neighbour = depth.at<float>(nv, nu);
    return neighbour > 0.0f && std::abs(neighbour - z) > fraction * z;
  };
  return differs(-1, 0) || differs(1, 0) || differs(0, -1) || differs(0, 1);
}

}  // namespace

void DenseCloudOptions::Validate() const {
  HIGHWALL_REQUIRE(min_depth > 0.0, "DenseCloudOptions::min_depth must be positive, is " +
                                        std::to_string(min_depth));
  HIGHWALL_REQUIRE(
      max_depth > min_depth,
      "DenseCloudOptions::max_depth must exceed min_depth, is " + std::to_string(max_depth));
  HIGHWALL_REQUIRE(stride >= 1,
                   "DenseCloudOptions::stride must be at least 1, is " + std::to_string(stride));
  HIGHWALL_REQUIRE(edge_rejection >= 0.0, "DenseCloudOptions::edge_rejection must not be negative");
  HIGHWALL_REQUIRE(
      voxel_size > 0.0 && std::isfinite(voxel_size),
      "DenseCloudOptions::voxel_size must be positive, is " + std::to_string(voxel_size));
}

std::vector<ColoredPoint> MakeKeyframeCloud(const cv::Mat& depth, const cv::Mat& bgr,
                                            const DepthUnprojector& unprojector,
                                            const DenseCloudOptions& options) {
  options.Validate();
  unprojector.RequireDepth(depth);
  HIGHWALL_REQUIRE(bgr.empty() || bgr.type() == CV_8UC3, "a colour image is CV_8UC3 (BGR)");
  HIGHWALL_REQUIRE(bgr.empty() || bgr.size() == depth.size(),
                   "the colour image differs in size from the depth image");
  const auto min_depth = static_cast<float>(options.min_depth);
  const auto max_depth = static_cast<float>(options.max_depth);
  const auto edge = static_cast<float>(options.edge_rejection);
  internal::VoxelFilter filter(options.voxel_size);
  for (int v = 0; v < depth.rows; v += options.stride) {
    for (int u = 0; u < depth.cols; u += options.stride) {
      const float z = depth.at<float>(v, u);
      if (!(z >= min_depth && z <= max_depth)) continue;
      if (edge > 0.0f && IsDepthEdge(depth, u, v, edge)) continue;
      ColoredPoint point{.p = unprojector.Unproject(u, v, z)};
      if (!bgr.empty()) {
        const cv::Vec3b& pixel = bgr.at<cv::Vec3b>(v, u);
        point.rgb = {pixel[2], pixel[1], pixel[0]};
      }
      filter.Add(point.p, point.rgb);
    }
  }
  return filter.Points();
}

std::vector<ColoredPoint> MakeKeyframeCloud(const cv::Mat& depth, const cv::Mat& bgr,
                                            const PinholeCamera& camera,
                                            const DenseCloudOptions& options) {
  return MakeKeyframeCloud(depth, bgr, DepthUnprojector(camera), options);
}

DenseCloud::DenseCloud(double voxel_size) : voxel_size_(voxel_size) {
  HIGHWALL_REQUIRE(voxel_size > 0.0 && std::isfinite(voxel_size),
                   "voxel_size must be positive, is " + std::to_string(voxel_size));
}

void DenseCloud::SetKeyframe(std::int64_t id, std::vector<ColoredPoint> cloud_C) {
  cloud_C.shrink_to_fit();
  keyframes_[id].cloud_C = std::move(cloud_C);
}

void DenseCloud::SetPose(std::int64_t id, const Pose& T_WC) {
  HIGHWALL_REQUIRE(T_WC.IsFinite(),
                   "the pose of keyframe " + std::to_string(id) + " is not finite");
  const auto keyframe = keyframes_.find(id);
  HIGHWALL_REQUIRE(keyframe != keyframes_.end(), "there is no keyframe " + std::to_string(id));
  keyframe->second.T_WC = T_WC;
}

const std::vector<ColoredPoint>& DenseCloud::Cloud(std::int64_t id) const {
  const auto keyframe = keyframes_.find(id);
  HIGHWALL_REQUIRE(keyframe != keyframes_.end(),
                   "DenseCloud::Cloud: no keyframe " + std::to_string(id));
  return keyframe->second.cloud_C;
}

void DenseCloud::RemoveKeyframe(std::int64_t id) {
  keyframes_.erase(id);
}

std::size_t DenseCloud::PointCount() const {
  std::size_t count = 0;
  for (const auto& [id, keyframe] : keyframes_) count += keyframe.cloud_C.size();
  return count;
}

std::vector<ColoredPoint> DenseCloud::Merged() const {
  internal::VoxelFilter filter(voxel_size_);
  for (const auto& [id, keyframe] : keyframes_) {
    if (!keyframe.T_WC) continue;
    const Eigen::Matrix3f R_WC = keyframe.T_WC->R().cast<float>();
    const Eigen::Vector3f p_WC = keyframe.T_WC->p().cast<float>();
    for (const ColoredPoint& point : keyframe.cloud_C) {
      filter.Add(R_WC * point.p + p_WC, point.rgb);
    }
  }
  return filter.Points();
}

}  // namespace highwall
