#pragma once

#include <opencv2/core/mat.hpp>

#include "svg.h"

namespace highwall::apps {

// The drawing as an image, CV_8UC3, `scale` pixels for one of the drawing. Letters that OpenCV's
// font has not (beyond ASCII) become question marks.
cv::Mat Rasterize(const Svg& svg, double scale);

}  // namespace highwall::apps
