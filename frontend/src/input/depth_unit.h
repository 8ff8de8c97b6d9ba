#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include <opencv2/core/mat.hpp>

namespace highwall {

// Returns whether depth [m] is plausible in metres: one reading in ten lies within 100 m, as with a
// depth camera. False if fewer than one pixel in a hundred have a reading, which is not conclusive.
// Throws InvalidArgument if more than nine readings in ten lie beyond: those are in the sensor's
// own unit.
bool IsMetric(const cv::Mat& depth);

// Returns what to say of a depth factor with which the median of five depth images, spread over a
// recording, is implausible. read: returns the depth [m] of an image below `images`; it may throw
// IoError, and the image is left out.
std::optional<std::string> DoubtOfDepthFactor(std::size_t images, double depth_factor,
                                              const std::function<cv::Mat(std::size_t)>& read);

}  // namespace highwall
