#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <opencv2/core/mat.hpp>

namespace highwall {

// True if the bytes begin as a JPEG does.
bool IsJpeg(std::span<const std::uint8_t> bytes);

struct JpegImage {
  cv::Mat pixels;              // CV_8UC1 if stored without colour, else CV_8UC3 in the order BGR
  bool has_warnings = false;  // of the decoder: the data ends early or is damaged somewhere
};

// Decodes a JPEG of grey or colour values by libjpeg-turbo, with the exact transform and smooth
// upsampling as OpenCV does; tags of orientation are ignored. Returns nullopt if it cannot be
// decoded or is of another colour space (CMYK).
std::optional<JpegImage> DecodeJpeg(std::span<const std::uint8_t> bytes);

}  // namespace highwall
