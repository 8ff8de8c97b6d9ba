#pragma once

#include <vector>

#include <opencv2/core/types.hpp>

namespace highwall::internal {

// Returns the `count` keypoints (all if there are fewer) that are strong and evenly spread over
// `area`: strongest first, each suppresses the weaker ones in a square around itself, and the side
// of the square is the largest that leaves `count` of them (Bailo, Rameau, Joo, Park, Bogdan,
// Kweon, "Efficient adaptive non-maximal suppression algorithms for homogeneous spatial keypoint
// distribution", 2018). Ties go to the upper, then the left keypoint, so that the input order does
// not matter. The strongest comes first. Positions must be integers in `area`, below 65536, and
// responses not negative, as cv::FAST gives them; no other field is kept.
std::vector<cv::KeyPoint> SelectEvenly(const std::vector<cv::KeyPoint>& keypoints, int count,
                                       const cv::Rect& area);

}  // namespace highwall::internal
