#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace highwall::internal {

// Returns the offset, within half a pixel along each axis, from the pixel (x, y) of a FAST corner
// to the peak of the parabolas through its FAST score and those of its neighbours. gray: CV_8UC1;
// (x, y) at least 4 pixels inside. Halves the distance between a corner and its match in a warped
// image.
cv::Point2f RefineCorner(const cv::Mat& gray, int x, int y);

}  // namespace highwall::internal
