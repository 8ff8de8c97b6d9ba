#pragma once

#include <opencv2/core/mat.hpp>

namespace highwall {

// Returns whether depth [m] is plausible in metres: one reading in ten lies within 100 m, as with a
// depth camera. False if fewer than one pixel in a hundred have a reading, which is not conclusive.
// Throws InvalidArgument if more than nine readings in ten lie beyond: those are in the sensor's
// own unit.
bool IsMetric(const cv::Mat& depth);

}  // namespace highwall
