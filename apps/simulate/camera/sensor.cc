#include "simulate/camera/sensor.h"

#include <cmath>
#include <limits>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>

#include "simulate/parallel_for.h"

namespace highwall::simulate {
namespace {

constexpr double kMaxDepthBias = 0.1;
constexpr double kBiasReference = 3.0;     // [m] reference depth of the bias option
constexpr double kKinectBaseline = 0.075;  // [m] projector to camera
constexpr double kDisparitySteps = 8.0;    // per pixel
constexpr int kMatchingWindow = 5;         // [px]
constexpr float kEdgeStep = 1.04f;         // ratio of depths at an edge
constexpr float kGrazingSure = 0.10f;      // cosine below which all depth is missing,
constexpr float kGrazingPossible = 0.26f;  // and above which none is

// Random numbers per pixel: depth, grazing, and two pairs for colour.
constexpr std::uint64_t kCountersPerPixel = 4;

double KinectSigma(double z) {
  return 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
}

double NoisyKinectDepth(double z, double error, double disparity_scale) {
  const double steps = std::round(kDisparitySteps * disparity_scale / (z + error));
  return steps > 0.0 ? kDisparitySteps * disparity_scale / steps : 0.0;
}

// Minimum depth within the matching window of each pixel.
cv::Mat NearestInWindow(const cv::Mat& depth) {
  cv::Mat nearest = depth.clone();
  nearest.setTo(std::numeric_limits<float>::infinity(), depth == 0.0f);  // no depth, no occlusion
  cv::erode(nearest, nearest, cv::Mat::ones(kMatchingWindow, kMatchingWindow, CV_8U));
  return nearest;
}

// [1/m] Offset of inverse depth for a relative depth error at the reference.
double OffsetOf(double share) {
  return -share / (kBiasReference * (1.0 + share));
}

bool IsLost(float cosine, float uniform) {
  return uniform * (kGrazingPossible - kGrazingSure) > cosine - kGrazingSure;
}

}  // namespace

void SensorOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(noise_ratio) && noise_ratio > 0.0,
                   "SensorOptions::noise_ratio must be positive");
  HIGHWALL_REQUIRE(std::isfinite(min_depth) && min_depth > 0.0,
                   "SensorOptions::min_depth must be positive");
  HIGHWALL_REQUIRE(std::isfinite(max_depth) && max_depth > min_depth,
                   "SensorOptions::max_depth must exceed min_depth");
  HIGHWALL_REQUIRE(std::abs(depth_bias) <= kMaxDepthBias,
                   "SensorOptions::depth_bias must be in [-0.1, 0.1]");
  HIGHWALL_REQUIRE(std::abs(depth_pattern) <= kMaxDepthBias,
                   "SensorOptions::depth_pattern must be in [-0.1, 0.1]");
  HIGHWALL_REQUIRE(std::isfinite(colour_sigma) && colour_sigma >= 0.0,
                   "SensorOptions::colour_sigma must not be negative");
  stereo.Validate();
  HIGHWALL_REQUIRE(std::isfinite(read_noise) && read_noise >= 0.0,
                   "SensorOptions::read_noise must not be negative");
  HIGHWALL_REQUIRE(std::isfinite(shot_noise) && shot_noise >= 0.0,
                   "SensorOptions::shot_noise must not be negative");
}

DepthNoise SensorOptions::Noise() const {
  return noise == SensorNoise::kD435i ? stereo.Noise() : DepthNoise::Kinect();
}

double SensorOptions::InverseDepthOffset() const {
  return OffsetOf(depth_bias) + 0.0;  // no negative zero
}

double SensorOptions::InverseDepthPattern(double x, double y) const {
  return OffsetOf(depth_pattern) * (0.5 * (x * x + y * y) - 1.0 / 3.0);
}

DepthPattern SensorOptions::Pattern() const {
  constexpr int kColumns = DepthPattern::kColumns, kRows = DepthPattern::kRows;
  constexpr double kStepX = 2.0 / (kColumns - 1), kStepY = 2.0 / (kRows - 1);
  // Mean excess of linear interpolation between the nodes over a parabola: h^2 / 6 for x^2.
  constexpr double kAbove = (kStepX * kStepX + kStepY * kStepY) / 12.0;
  DepthPattern pattern;
  for (int node = 0; node < DepthPattern::kNodes; ++node) {
    const int column = node % kColumns, row = node / kColumns;
    pattern.nodes[node] = InverseDepthPattern(kStepX * column - 1.0, kStepY * row - 1.0) -
                          kAbove * OffsetOf(depth_pattern);
  }
  return pattern;
}

Sensor::Sensor(const SensorOptions& options, const PinholeCamera& camera, std::uint64_t seed)
    : options_((options.Validate(), options)),
      disparity_scale_(camera.fx * kKinectBaseline),
      random_(seed),
      stereo_(options.stereo, options.noise_ratio, camera) {}

cv::Mat Sensor::Biased(const cv::Mat& depth) const {
  const double offset = options_.InverseDepthOffset();
  cv::Mat biased = depth.clone();
  biased.forEach<float>([&](float& z, const int* at) {
    const double x = 2.0 * at[1] / (depth.cols - 1) - 1.0, y = 2.0 * at[0] / (depth.rows - 1) - 1.0;
    const double rest =
        1.0 + (offset + options_.InverseDepthPattern(x, y)) * static_cast<double>(z);
    z = rest > 0.0 ? static_cast<float>(static_cast<double>(z) / rest) : 0.0F;
  });
  return biased;
}

cv::Mat Sensor::KinectDepth(const Rendering& rendering, const CounterRandom& random,
                            int threads) const {
  const cv::Mat nearest = NearestInWindow(rendering.depth);
  cv::Mat out = rendering.depth.clone();
  ParallelFor(out.rows, threads, [&](int v) {
    for (int u = 0; u < out.cols; ++u) {
      const float z = out.at<float>(v, u);
      if (z == 0.0f) continue;
      const std::uint64_t counter =
          kCountersPerPixel * static_cast<std::uint64_t>(v * out.cols + u);
      const bool behind_edge = z > kEdgeStep * nearest.at<float>(v, u);
      const bool lost = IsLost(rendering.cosine.at<float>(v, u), random.Uniform(counter + 1));
      const double depth = static_cast<double>(z);
      const double error = options_.noise_ratio * KinectSigma(depth) *
                           static_cast<double>(random.Normals(counter).x());
      out.at<float>(v, u) =
          behind_edge || lost
              ? 0.0f
              : static_cast<float>(NoisyKinectDepth(depth, error, disparity_scale_));
    }
  });
  return out;
}

cv::Mat Sensor::KinectColour(const cv::Mat& bgr, const CounterRandom& random, int threads) const {
  const auto sigma = static_cast<float>(options_.colour_sigma);
  cv::Mat out(bgr.size(), CV_8UC3);
  ParallelFor(bgr.rows, threads, [&](int v) {
    for (int u = 0; u < bgr.cols; ++u) {
      const std::uint64_t counter =
          kCountersPerPixel * static_cast<std::uint64_t>(v * bgr.cols + u);
      const Eigen::Vector2f first = random.Normals(counter + 2),
                            second = random.Normals(counter + 3);
      out.at<cv::Vec3b>(v, u) =
          bgr.at<cv::Vec3f>(v, u) + sigma * cv::Vec3f(first.x(), first.y(), second.x());
    }
  });
  return out;
}

cv::Mat Sensor::CameraColour(const cv::Mat& bgr, const CounterRandom& random, int threads,
                             double gain) const {
  const auto read = static_cast<float>(options_.read_noise * options_.read_noise * gain * gain);
  const auto shot = static_cast<float>(options_.shot_noise * gain);
  cv::Mat out(bgr.size(), CV_8UC3);
  ParallelFor(bgr.rows, threads, [&](int v) {
    const auto* ideal = bgr.ptr<cv::Vec3f>(v);
    auto* row = out.ptr<cv::Vec3b>(v);
    for (int u = 0; u < bgr.cols; ++u) {
      const std::uint64_t bits = random.Bits(static_cast<std::uint64_t>(v * bgr.cols + u));
      for (int k = 0; k < 3; ++k) {
        const float sigma = std::sqrt(read + shot * std::max(0.0f, ideal[u][k]));
        row[u][k] = cv::saturate_cast<uchar>(ideal[u][k] + sigma * normals_(bits, 12 * k));
      }
    }
  });
  return out;
}

SensorImages Sensor::Observe(const Rendering& ideal, int frame, int threads, double gain) const {
  const Rendering rendering{ideal.bgr, Biased(ideal.depth), ideal.cosine};
  const CounterRandom random = random_.Stream(static_cast<std::uint64_t>(frame));
  SensorImages out;
  switch (options_.noise) {
    case SensorNoise::kOff:
      rendering.bgr.convertTo(out.bgr, CV_8UC3);
      out.depth = rendering.depth;
      break;
    case SensorNoise::kKinect:
      out = {KinectColour(rendering.bgr, random, threads), KinectDepth(rendering, random, threads)};
      break;
    case SensorNoise::kD435i:
      out = {CameraColour(rendering.bgr, random, threads, gain),
             stereo_.Measure(rendering, random.Stream(1), threads)};
      break;
  }
  const auto near = static_cast<float>(options_.min_depth);
  const auto far = static_cast<float>(options_.max_depth);
  out.depth.forEach<float>([near, far](float& z, const int*) {
    if (!(z >= near && z <= far)) z = 0.0f;
  });
  return out;
}

}  // namespace highwall::simulate
