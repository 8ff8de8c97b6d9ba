#include <highwall/frontend/features/lbd_line_extractor.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>

#include "features/edge_lines.h"
#include "features/image_gradient.h"
#include "features/line_band_descriptor.h"
#include "features/line_refinement.h"

namespace highwall {
namespace {

constexpr int kMinImageSide = 16;  // [px] smallest image that is searched
// Maximum gap between merged fragments of one edge, as a share of the longer image side; at least
// kEnds.
constexpr double kMergeGap = 0.015625;
constexpr double kEnds = 10.0;  // [px] that two fragments lose at their ends at any resolution

// Returns oriented segments of at least min_length, clipped to the image.
std::vector<LineSegment> DetectLsd(const cv::Mat& gray, const internal::ImageGradient& gradient,
                                   float min_length) {
  std::vector<cv::Vec4f> lines;
  cv::createLineSegmentDetector(cv::LSD_REFINE_STD)->detect(gray, lines);
  // OpenCV's LSD works at 0.8 of the size and scales back without regard to pixel centres.
  constexpr float kShift = 0.5F / 0.8F - 0.5F;
  const Eigen::Array2f limit(static_cast<float>(gray.cols - 1), static_cast<float>(gray.rows - 1));
  std::vector<LineSegment> segments;
  for (const cv::Vec4f& line : lines) {
    LineSegment segment;
    segment.s = (Eigen::Array2f(line[0], line[1]) + kShift).max(0.0F).min(limit);
    segment.e = (Eigen::Array2f(line[2], line[3]) + kShift).max(0.0F).min(limit);
    if (!(segment.Length() >= min_length)) continue;
    segments.push_back(internal::OrientByGradient(gradient, segment));
  }
  return segments;
}

}  // namespace

struct LbdLineExtractor::Impl {
  LineExtractorOptions options;
  // Both hold memory that is used again for the next image.
  internal::ImageGradient gradient;
  internal::EdgeLines edge_lines;

  // Returns oriented segments of at least min_length, within the image of `gradient`.
  std::vector<LineSegment> Detect(const cv::Mat& gray, float min_length) {
    return options.detector == LineDetector::kLsd ? DetectLsd(gray, gradient, min_length)
                                                  : edge_lines.Detect(gradient, min_length);
  }
};

LbdLineExtractor::LbdLineExtractor(const LineExtractorOptions& options) {
  options.Validate();
  impl_ = std::make_unique<Impl>();
  impl_->options = options;
}
LbdLineExtractor::~LbdLineExtractor() = default;
LbdLineExtractor::LbdLineExtractor(LbdLineExtractor&&) noexcept = default;
LbdLineExtractor& LbdLineExtractor::operator=(LbdLineExtractor&&) noexcept = default;

const LineExtractorOptions& LbdLineExtractor::options() const {
  return impl_->options;
}

LineFeatures LbdLineExtractor::Extract(const cv::Mat& gray) {
  HIGHWALL_REQUIRE(!gray.empty() && gray.type() == CV_8UC1,
                   "LbdLineExtractor::Extract: the image must be CV_8UC1 and not empty");
  LineFeatures features;
  if (std::min(gray.cols, gray.rows) < kMinImageSide) return features;

  const LineExtractorOptions& options = impl_->options;
  internal::ImageGradient& gradient = impl_->gradient;
  gradient.Compute(gray);
  const double side = std::max(gray.cols, gray.rows);
  const float min_length = static_cast<float>(options.min_length * side);
  std::vector<LineSegment>& segments = features.segments;
  // Fragments of half the length may still be merged into a whole segment.
  const float min_fragment = std::max(8.0F, 0.5F * min_length);
  segments = impl_->Detect(gray, min_fragment);
  if (options.merge) {
    segments = internal::MergeCollinear(std::move(segments),
                                        static_cast<float>(std::max(kEnds, kMergeGap * side)));
  }
  std::erase_if(segments, [&](const LineSegment& line) { return line.Length() < min_length; });
  std::stable_sort(segments.begin(), segments.end(),
                   [](const auto& a, const auto& b) { return a.Length() > b.Length(); });
  segments.resize(std::min(segments.size(), static_cast<std::size_t>(options.max_lines)));
  if (segments.empty()) return features;

  const int count = static_cast<int>(segments.size());
  if (options.descriptors) features.descriptors.create(count, 32, CV_8U);
  for (int i = 0; i < count; ++i) {
    LineSegment& segment = segments[static_cast<std::size_t>(i)];
    if (options.refine) segment = internal::RefineSegment(gradient, segment);
    if (!options.descriptors) continue;
    const auto descriptor = internal::LineBandDescriptor(gradient, segment);
    std::ranges::copy(descriptor, features.descriptors.ptr<std::uint8_t>(i));
  }
  return features;
}

LineFeatures DescribeLines(const cv::Mat& gray, std::vector<LineSegment> segments) {
  HIGHWALL_REQUIRE(!gray.empty() && gray.type() == CV_8UC1,
                   "DescribeLines: the image must be CV_8UC1 and not empty");
  const internal::ImageGradient gradient(gray);
  LineFeatures features{std::move(segments), {}};
  if (features.segments.empty()) return features;
  features.descriptors.create(static_cast<int>(features.segments.size()), 32, CV_8U);
  for (std::size_t i = 0; i < features.segments.size(); ++i) {
    LineSegment& segment = features.segments[i];
    // Also false for an end that is not finite.
    HIGHWALL_REQUIRE(segment.Length() >= 1.0F && std::isfinite(segment.Length()),
                     "DescribeLines: segment " + std::to_string(i) + " is shorter than a pixel");
    segment = internal::OrientByGradient(gradient, segment);
    const auto descriptor = internal::LineBandDescriptor(gradient, segment);
    std::ranges::copy(descriptor, features.descriptors.ptr<std::uint8_t>(static_cast<int>(i)));
  }
  return features;
}

}  // namespace highwall
