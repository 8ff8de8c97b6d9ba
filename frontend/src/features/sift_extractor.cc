#include "features/sift_extractor.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>

#include "features/square_suppression.h"

namespace highwall {
namespace {

constexpr int kLayers = 3;   // per octave, Lowe 2004
constexpr int kOctaves = 5;  // blobs of the last one are some 25 px across
constexpr double kEdgeThreshold = 10.0, kSigma = 1.6;
// OpenCV treats the image of twice the size as if its first pixel coincided with that of the image;
// it lies a quarter of a pixel outside.
constexpr float kShift = 0.25F;

// Level from OpenCV's packed octave (a signed byte, the doubled image being -1) and layer (from 1).
int Level(const cv::KeyPoint& keypoint) {
  const auto octave = static_cast<std::int8_t>(keypoint.octave & 0xFF);
  const int layer = (keypoint.octave >> 8) & 0xFF;
  return kLayers * (octave + 1) + layer - 1;
}

std::pair<int, int> Pixel(const cv::KeyPoint& keypoint) {
  return {cvRound(keypoint.pt.x), cvRound(keypoint.pt.y)};
}

// Returns the indices of keypoints that are strong and evenly spread.
std::vector<std::size_t> SelectEvenly(const std::vector<cv::KeyPoint>& keypoints, int count,
                                      const cv::Size& image) {
  std::map<std::pair<int, int>, std::size_t> strongest;  // by pixel
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    if (Level(keypoints[i]) >= kLayers * kOctaves) continue;
    const auto [at, is_new] = strongest.emplace(Pixel(keypoints[i]), i);
    if (!is_new && keypoints[i].response > keypoints[at->second].response) at->second = i;
  }
  std::vector<cv::KeyPoint> pixels;
  for (const auto& [pixel, i] : strongest) {
    pixels.push_back(keypoints[i]);
    pixels.back().pt = cv::Point(pixel.first, pixel.second);
  }
  std::vector<std::size_t> selected;
  for (const cv::KeyPoint& pixel : internal::SelectEvenly(pixels, count, {{0, 0}, image})) {
    selected.push_back(strongest.at(Pixel(pixel)));
  }
  return selected;
}

// Takes the square root of each share of the sum: dot products of such are the Hellinger
// similarity.
void ToRootSift(cv::Mat* descriptors) {
  for (int i = 0; i < descriptors->rows; ++i) {
    cv::Mat row = descriptors->row(i);
    const double sum = cv::sum(row)[0];
    if (sum > 0.0) cv::sqrt(row / sum, row);
  }
}

}  // namespace

SiftExtractor::SiftExtractor(const SiftExtractorOptions& options)
    : options_((options.Validate(), options)),
      kind_{.name = "sift",
            .descriptor = DescriptorType::kFloat,
            .columns = 128,
            .pyramid = {.levels = kLayers * kOctaves, .scale_factor = std::exp2(1.0 / kLayers)}},
      sift_(cv::SIFT::create(0, kLayers, options.contrast_threshold, kEdgeThreshold, kSigma)) {}

ExtractedPoints SiftExtractor::Extract(const cv::Mat& gray) {
  HIGHWALL_REQUIRE(!gray.empty() && gray.type() == CV_8UC1,
                   "SiftExtractor::Extract: the image must be CV_8UC1 and not empty");
  std::vector<cv::KeyPoint> found;
  cv::Mat descriptors;
  sift_->detectAndCompute(gray, cv::noArray(), found, descriptors);
  ExtractedPoints points;
  for (const std::size_t i : SelectEvenly(found, options_.features, gray.size())) {
    cv::KeyPoint& keypoint = points.keypoints.emplace_back(found[i]);
    keypoint.octave = Level(found[i]);
    keypoint.pt -= cv::Point2f(kShift, kShift);
    points.descriptors.push_back(descriptors.row(static_cast<int>(i)));
  }
  ToRootSift(&points.descriptors);
  return points;
}

}  // namespace highwall
