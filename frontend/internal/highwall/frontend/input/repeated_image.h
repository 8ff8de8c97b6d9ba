#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace [[gnu::visibility("default")]] highwall {

// Detects a colour image that repeats the previous one, byte for byte or re-encoded, as delivered
// by cameras that have two rates or drop images. It is no second measurement: a stationary camera
// gives new noise with every image, half a grey level and more in each pixel, while re-encoding
// changes little, and only at the steps of the quantization.
class RepeatedImage {
 public:
  // Returns whether bgr repeats the image of the previous call. False for the first, for another
  // size, and for an image so uniform (a covered lens) that a new one would look no different.
  // Samples a grid of 80 positions along the longer side. Throws InvalidArgument unless bgr is
  // CV_8UC3.
  bool Update(const cv::Mat& bgr);

 private:
  int width_ = 0, height_ = 0;           // [px] of the previous image
  std::vector<std::uint8_t> samples_{};  // its grey levels
};

}  // namespace highwall
