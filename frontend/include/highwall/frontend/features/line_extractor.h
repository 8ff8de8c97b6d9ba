#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/abi.h>
#include <highwall/frontend/features/frame.h>

namespace [[gnu::visibility("default")]] highwall {

// The line segments of one image. Row i of `descriptors` (N x 32, CV_8U: 256 bits, Hamming
// distance) belongs to segment i.
struct LineFeatures {
  std::vector<LineSegment> segments;  // [px] in the image, the centre of its first pixel is (0, 0)
  cv::Mat descriptors;
};

// Detects and describes the line segments of images. A user-defined extractor replaces
// LbdLineExtractor in SlamSystem (docs/user_features.md).
class LineExtractor {
 public:
  virtual ~LineExtractor();

  // gray: CV_8UC1, not empty, the raw (distorted) camera image. The segments are in any order, each
  // at least a pixel long and within half a pixel of the image, its ends in the order that
  // LineSegment states; the same image must give the same lines. Called from one thread at a time,
  // but not always the same one, while a PointExtractor may work on another. An exception thrown
  // here ends the Track() call that requested it.
  virtual LineFeatures Extract(const cv::Mat& gray) = 0;

 protected:
  LineExtractor() = default;
  LineExtractor(const LineExtractor&) = default;
  LineExtractor& operator=(const LineExtractor&) = default;
};

}  // namespace highwall
