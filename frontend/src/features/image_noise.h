#pragma once

#include <opencv2/core/mat.hpp>

namespace highwall::internal {

// Standard deviation [grey levels] of the noise of a CV_8UC1 image: of what is left beside planes of
// brightness (the mask of Immerkaer, "Fast noise variance estimation", 1996), by the median, so
// that edges and texture count little; black and white pixels, which may be clipped, do not count.
// Grey levels are whole: 0 where half of the others is flat.
double NoiseSigma(const cv::Mat& gray);

}  // namespace highwall::internal
