#include "simulate/sensor.h"

#include <cmath>
#include <limits>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>

#include "simulate/parallel_for.h"

namespace highwall::simulate {
namespace {

constexpr double kKinectBaseline = 0.075;  // [m] projector to camera
constexpr double kDisparitySteps = 8.0;    // per pixel
constexpr int kMatchingWindow = 5;         // [px]
constexpr float kEdgeStep = 1.04f;         // ratio of depths that makes an edge
constexpr float kGrazingSure = 0.10f;      // cosine below which nothing returns,
constexpr float kGrazingPossible = 0.26f;  // and above which everything does

// The random numbers of a pixel: depth, grazing, and two pairs of colour.
constexpr std::uint64_t kCountersPerPixel = 4;

double KinectSigma(double z) {
  return 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
}

double KinectDepth(double z, double normal, double disparity_scale) {
  const double noisy = z + KinectSigma(z) * normal;
  const double steps = std::round(kDisparitySteps * disparity_scale / noisy);
  return steps > 0.0 ? kDisparitySteps * disparity_scale / steps : 0.0;
}

// The smallest depth within the matching window of each pixel.
cv::Mat NearestInWindow(const cv::Mat& depth) {
  cv::Mat nearest = depth.clone();
  nearest.setTo(std::numeric_limits<float>::infinity(), depth == 0.0f);  // nothing hides nothing
  cv::erode(nearest, nearest, cv::Mat::ones(kMatchingWindow, kMatchingWindow, CV_8U));
  return nearest;
}

bool IsLost(float cosine, float uniform) {
  return uniform * (kGrazingPossible - kGrazingSure) > cosine - kGrazingSure;
}

}  // namespace

void SensorOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(min_depth) && min_depth > 0.0,
                   "SensorOptions::min_depth must be positive");
  HIGHWALL_REQUIRE(std::isfinite(max_depth) && max_depth > min_depth,
                   "SensorOptions::max_depth must exceed min_depth");
  HIGHWALL_REQUIRE(std::isfinite(colour_sigma) && colour_sigma >= 0.0,
                   "SensorOptions::colour_sigma must not be negative");
}

Sensor::Sensor(const SensorOptions& options, const PinholeCamera& camera, std::uint64_t seed)
    : options_(options), disparity_scale_(camera.fx * kKinectBaseline), random_(seed) {
  options_.Validate();
}

SensorImages Sensor::Observe(const Rendering& rendering, int frame, int threads) const {
  const bool noisy = options_.noise == SensorNoise::kKinect;
  const CounterRandom random = random_.Stream(static_cast<std::uint64_t>(frame));
  const int w = rendering.depth.cols, h = rendering.depth.rows;
  SensorImages out{cv::Mat(h, w, CV_8UC3), cv::Mat(h, w, CV_32FC1)};
  const cv::Mat nearest = noisy ? NearestInWindow(rendering.depth) : cv::Mat();

  const auto observe_depth = [&](int u, int v, std::uint64_t counter) {
    double z = rendering.depth.at<float>(v, u);
    if (noisy && z > 0.0) {
      const bool behind_edge =
          rendering.depth.at<float>(v, u) > kEdgeStep * nearest.at<float>(v, u);
      const bool lost = IsLost(rendering.cosine.at<float>(v, u), random.Uniform(counter + 1));
      z = behind_edge || lost
              ? 0.0
              : KinectDepth(z, static_cast<double>(random.Normals(counter).x()), disparity_scale_);
    }
    const bool in_range = z >= options_.min_depth && z <= options_.max_depth;
    return in_range ? static_cast<float>(z) : 0.0f;
  };
  const auto observe_colour = [&](int u, int v, std::uint64_t counter) {
    cv::Vec3f bgr = rendering.bgr.at<cv::Vec3f>(v, u);
    if (noisy) {
      const Eigen::Vector2f first = random.Normals(counter + 2),
                            second = random.Normals(counter + 3);
      bgr +=
          static_cast<float>(options_.colour_sigma) * cv::Vec3f(first.x(), first.y(), second.x());
    }
    return cv::Vec3b(cv::saturate_cast<uchar>(bgr[0]), cv::saturate_cast<uchar>(bgr[1]),
                     cv::saturate_cast<uchar>(bgr[2]));
  };
  ParallelFor(h, threads, [&](int v) {
    for (int u = 0; u < w; ++u) {
      const std::uint64_t counter = kCountersPerPixel * static_cast<std::uint64_t>(v * w + u);
      out.depth.at<float>(v, u) = observe_depth(u, v, counter);
      out.bgr.at<cv::Vec3b>(v, u) = observe_colour(u, v, counter);
    }
  });
  return out;
}

}  // namespace highwall::simulate
