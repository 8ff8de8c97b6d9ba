#pragma once

#include <memory>
#include <vector>

#include <highwall/core/abi.h>
#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace highwall {

// A segment in an image [px]. As extracted, its brighter side lies to the left of the way from s
// to e as the image is seen (y down), so that the order of the ends means the same in every view.
struct LineSegment {
  Eigen::Vector2f s = Eigen::Vector2f::Zero();
  Eigen::Vector2f e = Eigen::Vector2f::Zero();

  float Length() const { return (e - s).norm(); }
  // Of the undirected segment [rad], in [0, pi), from x towards y.
  float Angle() const;
  Eigen::Vector2f Midpoint() const { return 0.5F * (s + e); }
};

enum class LineDetector {
  kLsd,      // von Gioi, Jakubowicz, Morel, Randall 2010; the paper's choice
  kEdLines,  // Akinlar, Topal 2011: as many lines in a fifth of the time
};

// "lsd" or "edlines".
const char* ToString(LineDetector detector);

struct LineExtractorOptions {
  LineDetector detector = LineDetector::kEdLines;
  double min_length = 0.04;  // shortest segment, as a share of the longer image side, (0, 1]
  int max_lines = 150;       // the longest are kept, > 0
  bool merge = true;         // join collinear fragments of one edge
  double merge_gap = 10.0;   // [px] largest gap between such fragments, >= 0
  bool refine = true;        // fit each segment to the sub-pixel peaks of the gradient across it
  bool descriptors = true;   // compute LBD

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Row i of `descriptors` (N x 32, CV_8U: 256 bits, Hamming distance) belongs to segment i.
struct LineFeatures {
  std::vector<LineSegment> segments;  // the longest first
  cv::Mat descriptors;                // LBD; empty when not asked for or without segments
};

// Straight line segments with line band descriptors (LBD; Zhang, Koch 2013).
//
// The result does not depend on cv::setNumThreads(), nor on earlier images. One extractor must not
// be used by two threads at once.
class LineExtractor {
 public:
  // Throws InvalidArgument naming the bad option.
  explicit LineExtractor(const LineExtractorOptions& options = {});
  ~LineExtractor();
  LineExtractor(LineExtractor&&) noexcept;
  LineExtractor& operator=(LineExtractor&&) noexcept;

  // gray: CV_8UC1. No features for an image without lines or with a side below 16 px.
  // Throws InvalidArgument on any other type or an empty image.
  LineFeatures Extract(const cv::Mat& gray);

  const LineExtractorOptions& options() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall
