#include "simulate/camera/motion_blur.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include <highwall/core/error.h>

#include "simulate/materials/lattice_noise.h"
#include "simulate/parallel_for.h"

namespace highwall::simulate {
namespace {

constexpr float kSharp = 0.3f;  // [px] shorter paths are not averaged
constexpr float kMaxTaps = 32.0f;

// Single precision is enough: a path is a difference of a few pixels.
struct Projection {
  Eigen::Matrix3f R;
  Eigen::Vector3f t;
  Eigen::Vector2f f;

  Projection(const Pose& T, const PinholeCamera& camera)
      : R(T.R().cast<float>()),
        t(T.p().cast<float>()),
        f(static_cast<float>(camera.fx), static_cast<float>(camera.fy)) {}

  // Returns the projection of the point at `inverse_depth` along (ray, 1), in [px] from the
  // principal point.
  Eigen::Vector2f operator()(const cv::Vec2f& ray, float inverse_depth) const {
    const Eigen::Vector3f p = R * Eigen::Vector3f(ray[0], ray[1], 1.0f) + inverse_depth * t;
    return f.cwiseProduct(p.head<2>()) / std::max(p.z(), 1e-3f);
  }
};

cv::Vec3f Interpolate(const cv::Mat& bgr, float x, float y) {
  x = std::clamp(x, 0.0f, static_cast<float>(bgr.cols - 1) - 1e-3f);
  y = std::clamp(y, 0.0f, static_cast<float>(bgr.rows - 1) - 1e-3f);
  const int i = Floor(x), j = Floor(y);
  const float a = x - static_cast<float>(i), b = y - static_cast<float>(j);
  const auto *low = bgr.ptr<cv::Vec3f>(j) + i, *high = bgr.ptr<cv::Vec3f>(j + 1) + i;
  const float w00 = (1 - a) * (1 - b), w01 = a * (1 - b), w10 = (1 - a) * b, w11 = a * b;
  cv::Vec3f sum;
  for (int k = 0; k < 3; ++k) {
    sum[k] = w00 * low[0][k] + w01 * low[1][k] + w10 * high[0][k] + w11 * high[1][k];
  }
  return sum;
}

}  // namespace

MotionBlur::MotionBlur(const PinholeCamera& camera) : camera_(camera) {
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2f ray = camera.Unproject({u, v}, 1.0).head<2>().cast<float>();
      rays_.emplace_back(ray.x(), ray.y());
    }
  }
}

cv::Mat MotionBlur::Apply(const cv::Mat& bgr, const cv::Mat& depth, const ExposureMotion& motion,
                          int threads) const {
  return Apply(bgr, depth, std::vector<ExposureMotion>(static_cast<std::size_t>(bgr.rows), motion),
               threads);
}

cv::Mat MotionBlur::Apply(const cv::Mat& bgr, const cv::Mat& depth,
                          std::span<const ExposureMotion> motion_of_row, int threads) const {
  HIGHWALL_REQUIRE(motion_of_row.size() == static_cast<std::size_t>(bgr.rows),
                   "MotionBlur: needs one motion per row");
  cv::Mat blurred(bgr.size(), bgr.type());
  ParallelFor(bgr.rows, threads, [&](int v) {
    const auto& [T_MB, T_ME] = motion_of_row[static_cast<std::size_t>(v)];
    const Projection begin(T_MB.Inverse(), camera_), end(T_ME.Inverse(), camera_);
    const auto* sharp = bgr.ptr<cv::Vec3f>(v);
    const auto* z = depth.ptr<float>(v);
    auto* out = blurred.ptr<cv::Vec3f>(v);
    const cv::Vec2f* rays =
        &rays_[static_cast<std::size_t>(v) * static_cast<std::size_t>(bgr.cols)];
    for (int u = 0; u < bgr.cols; ++u) {
      const float inverse_depth = z[u] > 0.0f ? 1.0f / z[u] : 0.0f;
      const Eigen::Vector2f way = end(rays[u], inverse_depth) - begin(rays[u], inverse_depth);
      const float length = way.norm();
      if (!(length > kSharp)) {
        out[u] = sharp[u];
        continue;
      }
      const float taps = std::min(std::ceil(length) + 1.0f, kMaxTaps);
      cv::Vec3f sum(0.0f, 0.0f, 0.0f);
      for (float k = 0.5f; k < taps; k += 1.0f) {
        const Eigen::Vector2f at = (k / taps - 0.5f) * way;
        sum += Interpolate(bgr, static_cast<float>(u) + at.x(), static_cast<float>(v) + at.y());
      }
      out[u] = sum * (1.0f / taps);
    }
  });
  return blurred;
}

}  // namespace highwall::simulate
