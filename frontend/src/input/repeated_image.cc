#include <highwall/frontend/input/repeated_image.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include <highwall/core/error.h>

namespace highwall {
namespace {

constexpr int kPlaces = 80;  // along the longer side

// [grey levels] Mean difference of a repeated image. A recorded image that is re-encoded as JPEG of
// quality 92 or better changes by 0.5 at most; two images with a noise of half a grey level each
// differ by 0.56, those of a still hand by 3.
constexpr double kMaxMean = 0.55;
// Bounds for something that moves before a camera without noise: [grey levels] a difference beyond
// re-encoding, and the share of positions that may exceed it.
constexpr int kMaxDifference = 12;
constexpr double kMaxShare = 0.002;
// Ratio of the mean difference to the mean of the image's own second differences: noise alone makes
// it sqrt(2) / sqrt(20) = 0.32; a textured image re-encoded as JPEG 92 has 0.05.
constexpr double kMaxRatio = 0.1;

int Grey(const cv::Vec3b& bgr) {
  return (bgr[0] + 2 * bgr[1] + bgr[2] + 2) / 4;
}

// |4 I - I_left - I_right - I_above - I_below| at an inner pixel.
int SecondDifference(const cv::Mat& bgr, int v, int u) {
  const auto* row = bgr.ptr<cv::Vec3b>(v);
  return std::abs(4 * Grey(row[u]) - Grey(row[u - 1]) - Grey(row[u + 1]) -
                  Grey(bgr.at<cv::Vec3b>(v - 1, u)) - Grey(bgr.at<cv::Vec3b>(v + 1, u)));
}

}  // namespace

bool RepeatedImage::Update(const cv::Mat& bgr) {
  HIGHWALL_REQUIRE(bgr.type() == CV_8UC3, "RepeatedImage: the image must be CV_8UC3");
  const int step = std::max(1, std::max(bgr.cols, bgr.rows) / kPlaces);
  std::vector<std::uint8_t> samples;
  samples.reserve(samples_.size());
  std::int64_t texture = 0;
  for (int v = 1 + (step - 1) / 2; v < bgr.rows - 1; v += step) {
    for (int u = 1 + (step - 1) / 2; u < bgr.cols - 1; u += step) {
      samples.push_back(static_cast<std::uint8_t>(Grey(bgr.at<cv::Vec3b>(v, u))));
      texture += SecondDifference(bgr, v, u);
    }
  }
  const bool comparable = bgr.cols == width_ && bgr.rows == height_;
  width_ = bgr.cols;
  height_ = bgr.rows;
  const std::vector<std::uint8_t> before = std::exchange(samples_, std::move(samples));
  if (!comparable) return false;

  std::int64_t sum = 0, far = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const int difference = std::abs(before[i] - samples_[i]);
    sum += difference;
    far += difference > kMaxDifference ? 1 : 0;
  }
  const auto count = static_cast<double>(before.size()), mean_sum = static_cast<double>(sum);
  return mean_sum <= kMaxMean * count && static_cast<double>(far) <= kMaxShare * count &&
         mean_sum < kMaxRatio * static_cast<double>(texture);
}

}  // namespace highwall
