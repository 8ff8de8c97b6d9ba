#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace highwall::internal {

// Finds the FAST-9 corners of an area: the same, in the same order, as cv::FAST with non-maximum
// suppression inside of the area (Rosten, Drummond, "Machine learning for high-speed corner
// detection", ECCV 2006), in half of the time. The scores that decide the suppression are
// computed for 32 pixels at a time by the test itself. Buffers are kept from call to call.
class FastCorners {
 public:
  // image: CV_8UC1. area: at least 3 pixels inside of the image. threshold: [0, 255] grey levels.
  void Append(const cv::Mat& image, const cv::Rect& area, int threshold,
              std::vector<cv::KeyPoint>* corners);

 private:
  // Appends the corners of a row, of which `first` is the first pixel.
  void AppendPeaks(const cv::Point& first, std::vector<cv::KeyPoint>* corners) const;

  std::vector<std::uint8_t> scores_;  // of three rows, with a border of 1 pixel; 0: no corner
  std::vector<std::uint8_t> peaks_;   // the scores of a row that are not suppressed
};

}  // namespace highwall::internal
