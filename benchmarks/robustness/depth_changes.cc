#include "depth_changes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "random_fields.h"

namespace highwall::bench {
namespace {

using simulate::CounterRandom;

// Returns the distance [px] from each pixel to the nearest depth edge, where adjacent readings
// differ by more than a relative threshold, or one is missing.
cv::Mat DistanceToEdges(const cv::Mat& depth) {
  constexpr double kStep = 0.05;
  cv::Mat near, far, distance;
  cv::erode(depth, near, {});
  cv::dilate(depth, far, {});
  const cv::Mat smooth = near > (1.0 - kStep) * far;  // 0 on edges
  cv::distanceTransform(smooth, distance, cv::DIST_L2, cv::DIST_MASK_3);
  return distance;
}

// Returns blobs in [0, 1] that change smoothly from one spell to the next.
cv::Mat Blobs(cv::Size size, std::size_t frame, const CounterRandom& random) {
  constexpr int kBlob = 32;           // [px]
  constexpr std::size_t kSpell = 15;  // [frames]
  const cv::Size cells(size.width / kBlob + 2, size.height / kBlob + 2);
  const double share = static_cast<double>(frame % kSpell) / kSpell;
  cv::Mat field = (1.0 - share) * UniformField(cells, random.Stream(frame / kSpell)) +
                  share * UniformField(cells, random.Stream(frame / kSpell + 1));
  cv::resize(field, field, size, 0.0, 0.0, cv::INTER_LINEAR);
  return field;
}

// Sets the readings with the highest scores to 0: `share` of all.
void TakeHighest(const cv::Mat& score, double share, cv::Mat* depth) {
  const cv::Mat measured = *depth > 0.0;
  std::vector<float> scores;
  scores.reserve(depth->total());
  for (int v = 0; v < depth->rows; ++v) {
    for (int u = 0; u < depth->cols; ++u) {
      if (measured.at<std::uint8_t>(v, u) != 0) scores.push_back(score.at<float>(v, u));
    }
  }
  const auto taken = std::lround(share * static_cast<double>(scores.size()));
  if (taken == 0) return;
  const auto last = scores.begin() + taken - 1;
  std::ranges::nth_element(scores, last, std::greater());
  depth->setTo(0.0, score >= *last);
}

}  // namespace

ImageChange DepthHoles(double share) {
  return [share](std::size_t frame, const CounterRandom& random, RgbdImage* image) {
    constexpr double kReach = 8.0;  // [px]
    cv::Mat near_edges = DistanceToEdges(image->depth) * (-1.0 / kReach);
    cv::exp(near_edges, near_edges);
    TakeHighest(near_edges + Blobs(image->depth.size(), frame, random), share, &image->depth);
  };
}

ImageChange DepthCut(double metres) {
  return [metres](std::size_t, const CounterRandom&, RgbdImage* image) {
    image->depth.setTo(0.0, image->depth > metres);
  };
}

ImageChange NoDepthFrom(std::size_t first) {
  return [first](std::size_t frame, const CounterRandom&, RgbdImage* image) {
    if (frame >= first) image->depth.setTo(0.0);
  };
}

ImageChange DepthNoiseOf(double quadratic) {
  return [quadratic](std::size_t frame, const CounterRandom& random, RgbdImage* image) {
    const cv::Mat noise =
        NormalField(image->depth.size(), CV_32FC1, quadratic, random.Stream(frame));
    // Missing depth stays 0; depth behind the camera becomes missing.
    const cv::Mat square = image->depth.mul(image->depth);
    image->depth = cv::max(image->depth + square.mul(noise), 0.0);
  };
}

}  // namespace highwall::bench
