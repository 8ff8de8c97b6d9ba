#include "features/line_validation.h"

#include <string>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

// Returns the fault of a segment; empty if it is valid.
std::string FaultOfSegment(const LineSegment& segment, const cv::Size& image) {
  for (const Eigen::Vector2f& end : {segment.s, segment.e}) {
    if (!end.allFinite()) return "ends at no finite place";
    // Pixels reach half a pixel around their centres.
    if (end.x() < -0.5F || end.y() < -0.5F || end.x() > static_cast<float>(image.width) - 0.5F ||
        end.y() > static_cast<float>(image.height) - 0.5F) {
      TextWriter fault;
      fault << "ends at (" << end.x() << ", " << end.y() << "), outside of the image of "
            << image.width << " x " << image.height;
      return fault.str();
    }
  }
  return segment.Length() < 1.0F ? "is shorter than a pixel" : "";
}

}  // namespace

void ValidateLines(const LineFeatures& lines, const cv::Size& image) {
  for (std::size_t i = 0; i < lines.segments.size(); ++i) {
    const std::string fault = FaultOfSegment(lines.segments[i], image);
    HIGHWALL_REQUIRE(fault.empty(), "lines: segment " + std::to_string(i) + " " + fault);
  }
  const cv::Mat& descriptors = lines.descriptors;
  HIGHWALL_REQUIRE(static_cast<std::size_t>(descriptors.rows) == lines.segments.size(),
                   "lines: " + std::to_string(lines.segments.size()) + " segments have " +
                       std::to_string(descriptors.rows) +
                       " rows of descriptors; DescribeLines() makes them");
  if (lines.segments.empty()) return;
  HIGHWALL_REQUIRE(descriptors.dims == 2 && descriptors.type() == CV_8UC1 && descriptors.cols == 32,
                   "lines: descriptors must be CV_8U with 32 columns; DescribeLines() makes them");
}

}  // namespace highwall
