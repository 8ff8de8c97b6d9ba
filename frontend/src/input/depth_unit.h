#pragma once

#include <opencv2/core/mat.hpp>

namespace highwall {

// Whether depth [m] is seen to be in metres: one reading in ten lies within 100 m, as with a depth
// camera. False where fewer than one pixel in a hundred have a reading, which decides nothing.
// Throws InvalidArgument where more than nine readings in ten lie beyond: those are in the sensor's
// own unit.
bool IsMetric(const cv::Mat& depth);

}  // namespace highwall
