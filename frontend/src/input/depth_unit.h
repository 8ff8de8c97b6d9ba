#pragma once

#include <opencv2/core/mat.hpp>

namespace highwall {

// Whether depth [m] has a reading within 100 m, as that of a depth camera in metres has. Throws
// InvalidArgument where one pixel in a hundred or more has a reading, and all are beyond: those are
// in the sensor's own unit.
bool IsMetric(const cv::Mat& depth);

}  // namespace highwall
