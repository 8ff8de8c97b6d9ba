#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace highwall::internal {

// Finds the FAST-9 corners of an area: the same, in the same order, as cv::FAST with non-maximum
// suppression inside of the area (Rosten, Drummond, "Machine learning for high-speed corner
// detection", ECCV 2006), in two thirds of the time. The scores that decide the suppression are
// computed for 32 pixels at a time by the test itself. The buffer is kept from call to call.
class FastCorners {
 public:
  // image: CV_8UC1. area: at least 3 pixels inside of the image. threshold: [0, 254] grey levels.
  void Append(const cv::Mat& image, const cv::Rect& area, int threshold,
              std::vector<cv::KeyPoint>* corners);

 private:
  // Computes scores_.
  void Score(const cv::Mat& image, const cv::Rect& area, std::uint8_t threshold);
  // Returns the first of a row of the area in scores_.
  std::uint8_t* Row(int y);

  std::vector<std::uint8_t> scores_;  // of the area with a border of 1 pixel, 0: no corner
  std::size_t stride_ = 0;            // of a row of scores_
  std::vector<std::uint8_t> peaks_;   // the scores of a row that are not suppressed
};

}  // namespace highwall::internal
