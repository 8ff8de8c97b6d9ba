#pragma once

#include <span>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace highwall::internal {

// Returns the ORB descriptors (rotated BRIEF, Rublee et al. 2011) of corners, one row of 32 bytes
// (CV_8UC1) each. They agree with those of cv::ORB up to the rounding of the smoothed image, which
// here is the same on every processor, and of the pixel beyond an edge that is 17 away. image:
// CV_8UC1, at least 8 pixels wide and high; pt: pixel at least 17 from its edges; angle [deg].
cv::Mat DescribeOrb(const cv::Mat& image, std::span<const cv::KeyPoint> corners);

}  // namespace highwall::internal
