#pragma once

#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/abi.h>
#include <highwall/frontend/features/line_extractor.h>
#include <highwall/frontend/features/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Extracts straight line segments, the longest first, by EDLines or LSD, with line band descriptors
// (LBD; Zhang, Koch 2013), which are empty if not requested or without segments.
//
// The result does not depend on cv::setNumThreads(), nor on earlier images. One extractor must not
// be used by two threads at the same time.
class LbdLineExtractor final : public LineExtractor {
 public:
  // Throws InvalidArgument naming the bad option.
  explicit LbdLineExtractor(const LineExtractorOptions& options = {});
  ~LbdLineExtractor() override;
  LbdLineExtractor(LbdLineExtractor&&) noexcept;
  LbdLineExtractor& operator=(LbdLineExtractor&&) noexcept;

  // gray: CV_8UC1. Returns no features for an image without lines or with a side below 16 px.
  // Throws InvalidArgument for any other type or an empty image.
  LineFeatures Extract(const cv::Mat& gray) override;

  const LineExtractorOptions& options() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Orders the ends of segments as LineSegment states and describes them by LBD, for a LineExtractor
// whose method does neither. gray: CV_8UC1, not empty, the image of the segments. The segments stay
// in their order. Throws InvalidArgument for another image, and for a segment whose ends are not
// finite or less than a pixel apart.
LineFeatures DescribeLines(const cv::Mat& gray, std::vector<LineSegment> segments);

}  // namespace highwall
