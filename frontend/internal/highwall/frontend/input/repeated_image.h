#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace [[gnu::visibility("default")]] highwall {

// Tells a colour image that is the one before once more, byte for byte or coded anew, as cameras
// hand out that have two rates or drop images. It is no second look: a camera that stands still
// gives new noise with every image, half a grey level and more in each pixel, while coding anew
// changes little, and that at the steps only.
class RepeatedImage {
 public:
  // Whether bgr repeats the image of the call before. False for the first, for another size, and
  // for an image so plain (a covered lens) that a new one would look no different. Looks at a grid
  // of 80 places along the longer side. Throws InvalidArgument unless bgr is CV_8UC3.
  bool Update(const cv::Mat& bgr);

 private:
  int width_ = 0, height_ = 0;           // [px] of the image before
  std::vector<std::uint8_t> samples_{};  // its grey levels
};

}  // namespace highwall
