#include "input/depth_registration.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <opencv2/core.hpp>

#include <highwall/internal/require.h>

#include "input/lens_reach.h"

namespace highwall {
namespace {

// Readings whose depths differ by a smaller share are of one surface: one that is seen at 75
// degrees changes by 2 % from pixel to pixel at a focal length of 200 px.
constexpr float kOneSurface = 0.03F;
// Above this number of colour pixels per depth pixel, values are interpolated.
constexpr float kMuchLarger = 1.5F;

// The pixels from `from` to `to`, within [0, count).
struct PixelRange {
  int begin = 0, end = 0;
};

PixelRange PixelsBetween(float from, float to, int count) {
  const float last = static_cast<float>(count);
  return {static_cast<int>(std::ceil(std::clamp(from, 0.0F, last))),
          static_cast<int>(std::floor(std::clamp(to, -1.0F, last - 1.0F))) + 1};
}

// Returns a row of an image; null if the image is empty.
int* RowOf(cv::Mat& image, int row) {
  return image.empty() ? nullptr : image.ptr<int>(row);
}

// reading: DepthRegistration::Registered::reading.
cv::Mat FactorOfReadings(const cv::Mat& factor, const cv::Mat& reading) {
  cv::Mat registered(reading.size(), CV_32FC1, cv::Scalar(1.0));
  for (int v = 0; v < reading.rows; ++v) {
    const int* const index = reading.ptr<int>(v);
    float* const to = registered.ptr<float>(v);
    for (int u = 0; u < reading.cols; ++u) {
      if (index[u] >= 0) to[u] = factor.at<float>(index[u] / factor.cols, index[u] % factor.cols);
    }
  }
  return registered;
}

}  // namespace

DepthRegistration::DepthRegistration(const PinholeCamera& colour,
                                     const DepthCameraCalibration& depth)
    : colour_(colour), columns_(depth.camera.width), rows_(depth.camera.height) {
  colour.Validate();
  depth.camera.Validate();
  constexpr double kMargin = 1.05;  // half a pixel beyond the image
  reach_ = static_cast<float>(kMargin * SquaredReach(colour));
  const Eigen::Matrix3d R_CD = depth.T_CD.R();
  rays_C_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (int v = 0; v < rows_; ++v) {
    for (int u = 0; u < columns_; ++u) {
      rays_C_.push_back((R_CD * depth.camera.Unproject(Eigen::Vector2d(u, v), 1.0)).cast<float>());
    }
  }
  p_CD_ = depth.T_CD.p().cast<float>();
  // A little more than half: neighbouring pixels of a surface that approaches leave no gap.
  constexpr double kOverlap = 1.1;
  half_width_ = static_cast<float>(std::max(0.5, 0.5 * kOverlap * colour.fx / depth.camera.fx));
  half_height_ = static_cast<float>(std::max(0.5, 0.5 * kOverlap * colour.fy / depth.camera.fy));
}

cv::Mat DepthRegistration::Register(const cv::Mat& depth, cv::Mat* noise_factor) const {
  HIGHWALL_REQUIRE(depth.type() == CV_32FC1 && depth.cols == columns_ && depth.rows == rows_,
                   "DepthRegistration: depth must be CV_32FC1 of the size of its camera");
  const bool has_factor = noise_factor != nullptr && !noise_factor->empty();
  HIGHWALL_REQUIRE(
      !has_factor || (noise_factor->type() == CV_32FC1 && noise_factor->size() == depth.size()),
      "DepthRegistration: noise_factor must be CV_32FC1 of the size of depth");
  const std::vector<Seen> seen = Project(depth);
  Registered registered{.depth = cv::Mat::zeros(colour_.height, colour_.width, CV_32FC1)};
  if (has_factor) registered.reading = cv::Mat(registered.depth.size(), CV_32SC1, cv::Scalar(-1));
  Splat(seen, &registered);
  if (std::max(half_width_, half_height_) > 0.5F * kMuchLarger) Interpolate(seen, &registered);
  if (has_factor) *noise_factor = FactorOfReadings(*noise_factor, registered.reading);
  return registered.depth;
}

std::vector<DepthRegistration::Seen> DepthRegistration::Project(const cv::Mat& depth) const {
  constexpr float kNearest = 0.01F;  // [m] in front of the colour camera
  std::vector<Seen> seen(rays_C_.size());
  std::size_t i = 0;
  for (int row = 0; row < rows_; ++row) {
    const float* const z_D = depth.ptr<float>(row);
    for (int column = 0; column < columns_; ++column, ++i) {
      if (!(z_D[column] > 0.0F)) continue;
      const Eigen::Vector3f p_C = z_D[column] * rays_C_[i] + p_CD_;
      if (!(p_C.z() > kNearest)) continue;
      if (p_C.head<2>().squaredNorm() > reach_ * p_C.z() * p_C.z()) continue;
      const Eigen::Vector2d uv = colour_.Project(p_C.cast<double>());
      seen[i] = {static_cast<float>(uv.x()), static_cast<float>(uv.y()), p_C.z()};
    }
  }
  return seen;
}

void DepthRegistration::Splat(const std::vector<Seen>& seen, Registered* registered) const {
  cv::Mat& depth = registered->depth;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Seen& at = seen[i];
    if (at.z == 0.0F) continue;
    const PixelRange u = PixelsBetween(at.u - half_width_, at.u + half_width_, depth.cols);
    const PixelRange v = PixelsBetween(at.v - half_height_, at.v + half_height_, depth.rows);
    for (int y = v.begin; y < v.end; ++y) {
      float* const z = depth.ptr<float>(y);
      int* const reading = RowOf(registered->reading, y);
      for (int x = u.begin; x < u.end; ++x) {
        if (z[x] != 0.0F && at.z >= z[x]) continue;
        z[x] = at.z;
        if (reading != nullptr) reading[x] = static_cast<int>(i);
      }
    }
  }
}

// Between the centres of four neighbouring readings of one surface, linear in the inverse depth.
void DepthRegistration::Interpolate(const std::vector<Seen>& seen, Registered* registered) const {
  cv::Mat& depth = registered->depth;
  const auto stride = static_cast<std::size_t>(columns_);
  for (std::size_t i = 0; i + stride + 1 < seen.size(); ++i) {
    if ((i + 1) % stride == 0) continue;
    const Seen &a = seen[i], &b = seen[i + 1], &c = seen[i + stride], &d = seen[i + stride + 1];
    const float nearest = std::min({a.z, b.z, c.z, d.z}), farthest = std::max({a.z, b.z, c.z, d.z});
    if (nearest == 0.0F || farthest > nearest * (1.0F + kOneSurface)) continue;
    const float u0 = 0.5F * (a.u + c.u), u1 = 0.5F * (b.u + d.u);
    const float v0 = 0.5F * (a.v + b.v), v1 = 0.5F * (c.v + d.v);
    if (!(u1 > u0) || !(v1 > v0)) continue;
    const PixelRange u = PixelsBetween(u0, u1, depth.cols);
    const PixelRange v = PixelsBetween(v0, v1, depth.rows);
    for (int y = v.begin; y < v.end; ++y) {
      const float t = (static_cast<float>(y) - v0) / (v1 - v0);
      const float left = (1.0F - t) / a.z + t / c.z, right = (1.0F - t) / b.z + t / d.z;
      float* const z = depth.ptr<float>(y);
      int* const reading = RowOf(registered->reading, y);
      const std::size_t first = t < 0.5F ? i : i + stride;  // of the nearest row
      for (int x = u.begin; x < u.end; ++x) {
        const float s = (static_cast<float>(x) - u0) / (u1 - u0);
        const float inside = 1.0F / ((1.0F - s) * left + s * right);
        // Keeps a nearer surface in front of this one.
        if (z[x] != 0.0F && inside >= z[x] * (1.0F + kOneSurface)) continue;
        z[x] = inside;
        if (reading != nullptr) reading[x] = static_cast<int>(s < 0.5F ? first : first + 1);
      }
    }
  }
}

}  // namespace highwall
