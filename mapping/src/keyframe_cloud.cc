#include <highwall/mapping/keyframe_cloud.h>

#include <cmath>
#include <numbers>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

#include "voxel_filter.h"

namespace highwall {
namespace {

// Returns true if one of the four neighbours is measured and differs by more than `fraction` of z.
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

// Returns the normal, towards the camera, from the points `radius` pixels to each side, or on one
// side only if the other has none on the same surface; zero if neither has one.
Eigen::Vector3f NormalAt(const cv::Mat& depth, const DepthUnprojector& unprojector, int u, int v,
                         int radius) {
  constexpr float kSameSurface = 0.1f;  // of the depth
  const float z = depth.at<float>(v, u);
  const Eigen::Vector3f p_C = unprojector.Unproject(u, v, z);
  const auto neighbour = [&](int du, int dv, Eigen::Vector3f& n_C) {
    const int nu = u + du, nv = v + dv;
    if (nu < 0 || nv < 0 || nu >= depth.cols || nv >= depth.rows) return false;
    const float n_z = depth.at<float>(nv, nu);
    if (!(n_z > 0.0f && std::abs(n_z - z) <= kSameSurface * z)) return false;
    n_C = unprojector.Unproject(nu, nv, n_z);
    return true;
  };
  Eigen::Vector3f left = p_C, right = p_C, up = p_C, down = p_C;
  const bool across = neighbour(-radius, 0, left) | neighbour(radius, 0, right);
  const bool along = neighbour(0, -radius, up) | neighbour(0, radius, down);
  if (!across || !along) return Eigen::Vector3f::Zero();
  // x right, y down, z forward: y cross x points towards the camera.
  return (down - up).cross(right - left).stableNormalized();
}

}  // namespace

void KeyframeCloudOptions::Validate() const {
  RequirePositive(min_depth, "KeyframeCloudOptions::min_depth");
  HIGHWALL_REQUIRE(
      max_depth > min_depth,
      "KeyframeCloudOptions::max_depth must exceed min_depth, is " + FixedText(max_depth));
  RequireAtLeast(stride, 1, "KeyframeCloudOptions::stride");
  HIGHWALL_REQUIRE(edge_rejection >= 0.0,
                   "KeyframeCloudOptions::edge_rejection must not be negative");
  HIGHWALL_REQUIRE(
      max_incidence > 0.0 && max_incidence <= 90.0,
      "KeyframeCloudOptions::max_incidence must lie in (0, 90], is " + FixedText(max_incidence));
  RequireAtLeast(normal_radius, 1, "KeyframeCloudOptions::normal_radius");
  RequirePositiveFinite(voxel_size, "KeyframeCloudOptions::voxel_size");
}

std::vector<ColoredPoint> MakeKeyframeCloud(const cv::Mat& depth, const cv::Mat& bgr,
                                            const DepthUnprojector& unprojector,
                                            const KeyframeCloudOptions& options) {
  options.Validate();
  unprojector.RequireDepth(depth);
  HIGHWALL_REQUIRE(bgr.empty() || bgr.type() == CV_8UC3, "a colour image is CV_8UC3 (BGR)");
  HIGHWALL_REQUIRE(bgr.empty() || bgr.size() == depth.size(),
                   "the colour image differs in size from the depth image");
  const auto min_depth = static_cast<float>(options.min_depth);
  const auto max_depth = static_cast<float>(options.max_depth);
  const auto edge = static_cast<float>(options.edge_rejection);
  const auto min_cosine =
      static_cast<float>(std::cos(options.max_incidence * std::numbers::pi / 180.0));
  const bool any_incidence = options.max_incidence == 90.0;
  internal::VoxelFilter filter(options.voxel_size);
  for (int v = 0; v < depth.rows; v += options.stride) {
    for (int u = 0; u < depth.cols; u += options.stride) {
      const float z = depth.at<float>(v, u);
      if (!(z >= min_depth && z <= max_depth)) continue;
      if (edge > 0.0f && IsDepthEdge(depth, u, v, edge)) continue;
      ColoredPoint point{.p = unprojector.Unproject(u, v, z),
                         .normal = NormalAt(depth, unprojector, u, v, options.normal_radius)};
      if (!any_incidence && -point.normal.dot(point.p.normalized()) < min_cosine) continue;
      if (!bgr.empty()) {
        const cv::Vec3b& pixel = bgr.at<cv::Vec3b>(v, u);
        point.rgb = {pixel[2], pixel[1], pixel[0]};
      }
      filter.Add(point);
    }
  }
  return filter.Points();
}

std::vector<ColoredPoint> MakeKeyframeCloud(const cv::Mat& depth, const cv::Mat& bgr,
                                            const PinholeCamera& camera,
                                            const KeyframeCloudOptions& options) {
  return MakeKeyframeCloud(depth, bgr, DepthUnprojector(camera), options);
}

}  // namespace highwall
