#include "features/point_validation.h"

#include <cmath>
#include <string>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

// Returns the fault of a keypoint; empty if it is valid.
std::string FaultOf(const cv::KeyPoint& keypoint, int levels, const cv::Size& image) {
  const cv::Point2f& pt = keypoint.pt;
  if (!std::isfinite(pt.x) || !std::isfinite(pt.y)) return "is at no finite place";
  // Pixels reach half a pixel around their centres.
  if (pt.x < -0.5F || pt.y < -0.5F || pt.x > static_cast<float>(image.width) - 0.5F ||
      pt.y > static_cast<float>(image.height) - 0.5F) {
    TextWriter fault;
    fault << "is at (" << pt.x << ", " << pt.y << "), outside of the image of " << image.width
          << " x " << image.height;
    return fault.str();
  }
  if (keypoint.octave < 0 || keypoint.octave >= levels) {
    return "has octave " + std::to_string(keypoint.octave) + ", but FeatureType::pyramid has " +
           std::to_string(levels) + " levels from 0";
  }
  if (!std::isfinite(keypoint.angle) || keypoint.angle > 360.0F) return "has no angle of 0 to 360";
  if (!std::isfinite(keypoint.response)) return "has no finite response";
  return "";
}

std::string FaultOf(const cv::Mat& descriptors, const FeatureType& kind, std::size_t keypoints) {
  if (static_cast<std::size_t>(descriptors.rows) != keypoints) {
    return std::to_string(keypoints) + " keypoints have " + std::to_string(descriptors.rows) +
           " rows of descriptors";
  }
  if (keypoints == 0) return "";
  const bool is_float = kind.descriptor == DescriptorType::kFloat;
  if (descriptors.dims != 2 || descriptors.type() != (is_float ? CV_32FC1 : CV_8UC1)) {
    return std::string("descriptors are not ") + (is_float ? "CV_32F" : "CV_8U") +
           ", as FeatureType::descriptor says";
  }
  if (descriptors.cols != kind.columns) {
    return "descriptors have " + std::to_string(descriptors.cols) + " columns, not " +
           std::to_string(kind.columns) + " as FeatureType::columns says";
  }
  cv::Point bad;
  // The bounds exclude values whose sums of products are not finite.
  if (is_float && !cv::checkRange(descriptors, true, &bad, -1e15, 1e15)) {
    return "the descriptor of keypoint " + std::to_string(bad.y) +
           " has a value that is not finite";
  }
  return "";
}

}  // namespace

void ValidatePoints(const ExtractedPoints& points, const FeatureType& kind, const cv::Size& image) {
  const std::string whose = "points by " + kind.name + ": ";
  for (std::size_t i = 0; i < points.keypoints.size(); ++i) {
    const std::string fault = FaultOf(points.keypoints[i], kind.pyramid.levels, image);
    HIGHWALL_REQUIRE(fault.empty(), whose + "keypoint " + std::to_string(i) + " " + fault);
  }
  const std::string fault = FaultOf(points.descriptors, kind, points.keypoints.size());
  HIGHWALL_REQUIRE(fault.empty(), whose + fault);
}

}  // namespace highwall
