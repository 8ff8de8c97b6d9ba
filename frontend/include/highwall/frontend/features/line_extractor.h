#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/abi.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Row i of `descriptors` (N x 32, CV_8U: 256 bits, Hamming distance) belongs to segment i.
struct LineFeatures {
  std::vector<LineSegment> segments;  // the longest first
  cv::Mat descriptors;                // LBD; empty if not requested or without segments
};

// Extracts straight line segments with line band descriptors (LBD; Zhang, Koch 2013).
//
// The result does not depend on cv::setNumThreads(), nor on earlier images. One extractor must not
// be used by two threads at the same time.
class LineExtractor {
 public:
  // Throws InvalidArgument naming the bad option.
  explicit LineExtractor(const LineExtractorOptions& options = {});
  ~LineExtractor();
  LineExtractor(LineExtractor&&) noexcept;
  LineExtractor& operator=(LineExtractor&&) noexcept;

  // gray: CV_8UC1. Returns no features for an image without lines or with a side below 16 px.
  // Throws InvalidArgument for any other type or an empty image.
  LineFeatures Extract(const cv::Mat& gray);

  const LineExtractorOptions& options() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
