#pragma once

#include <opencv2/core/mat.hpp>

namespace highwall::internal {

// Standard deviation [grey levels] of the noise of a CV_8UC1 image: of the residual of planes of
// brightness (the mask of Immerkaer, "Fast noise variance estimation", 1996), by the median, so
// that edges and texture have little influence; black and white pixels, which may be clipped, are
// not used. Grey levels are integers: the result is 0 if half of the other pixels are flat.
double NoiseSigma(const cv::Mat& gray);

}  // namespace highwall::internal
