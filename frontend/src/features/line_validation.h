#pragma once

#include <opencv2/core/types.hpp>

#include <highwall/frontend/features/line_extractor.h>

namespace highwall {

// Throws InvalidArgument, naming the fault, if the lines are not as LineExtractor says: a segment
// that is outside of the image, shorter than a pixel or not finite, and descriptors that are not
// CV_8U of 32 columns, one row for each segment.
void ValidateLines(const LineFeatures& lines, const cv::Size& image);

}  // namespace highwall
