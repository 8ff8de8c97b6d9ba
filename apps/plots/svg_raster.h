#pragma once

#include <opencv2/core/mat.hpp>

#include "plots/svg.h"

namespace highwall::apps {

// Returns the drawing as CV_8UC3 image, with `scale` pixels per px of the drawing. Characters
// missing in OpenCV's font (beyond ASCII) become question marks.
cv::Mat Rasterize(const Svg& svg, double scale);

}  // namespace highwall::apps
