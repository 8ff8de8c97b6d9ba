#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace highwall::internal {

// Finds the FAST-9 corners in small areas: the same, in the same order, as cv::FAST with
// non-maximum suppression inside of the area (Rosten, Drummond, "Machine learning for high-speed
// corner detection", ECCV 2006). A call of cv::FAST allocates its buffers anew, which takes longer
// than the search of a cell.
class FastCorners {
 public:
  // image: CV_8UC1. area: at least 3 pixels inside of the image. threshold: [0, 254] grey levels.
  void Append(const cv::Mat& image, const cv::Rect& area, int threshold,
              std::vector<cv::KeyPoint>* corners);

 private:
  std::vector<std::uint8_t> scores_;  // of the area with a border of 1 pixel, 0: no corner
};

}  // namespace highwall::internal
