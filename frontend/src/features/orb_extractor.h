#pragma once

#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/frontend/features/options.h>

namespace highwall {

// Row i of `descriptors` (N x 32, CV_8U: 256 bits, Hamming distance) belongs to keypoint i.
struct OrbFeatures {
  // pt [px of the input image], octave, angle [deg, 0 to 360, from x towards y], response (FAST
  // score), size [px] (diameter of the described patch). By octave, the strongest first.
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;  // empty when there are no keypoints
};

// Oriented FAST corners with rotated BRIEF descriptors (Rublee, Rabaud, Konolige, Bradski 2011) on
// a scale pyramid, spread evenly over the image: weak corners where there are no strong ones, and
// strongest-first suppression by squares whose side is chosen so that the budget is met (Bailo et
// al. 2018). Descriptors are bit-compatible with cv::ORB's.
//
// Extract() is const and thread-safe; its result does not depend on cv::setNumThreads().
class OrbExtractor {
 public:
  // Throws InvalidArgument naming the bad option.
  explicit OrbExtractor(const OrbExtractorOptions& options = {});
  ~OrbExtractor();
  OrbExtractor(OrbExtractor&&) noexcept;
  OrbExtractor& operator=(OrbExtractor&&) noexcept;

  // gray: CV_8UC1. Empty features for an image without texture or too small for a patch.
  // Throws InvalidArgument on any other type or an empty image.
  OrbFeatures Extract(const cv::Mat& gray) const;

  const OrbExtractorOptions& options() const;
  // scale_factor^level: the size of a pixel of that level in pixels of the image.
  double Scale(int level) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace highwall
