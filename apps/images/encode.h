#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

// Encoders by libdeflate and libjpeg-turbo: OpenCV's own load some 140 libraries.
namespace highwall {

// Of 0 (none) to 12: higher levels cost more time than writing more bytes does.
inline constexpr int kPngCompression = 3;

// Encodes CV_8UC1, CV_16UC1, CV_8UC3 (BGR) or CV_8UC4 (BGRA) without loss. Throws
// std::invalid_argument for other types, empty images, and a compression beyond its range.
// Source: PNG Specification (W3C, 2nd edition).
std::vector<std::uint8_t> EncodePng(const cv::Mat& image, int compression = kPngCompression);

// Encodes CV_8UC1 or CV_8UC3 (BGR), colour at half the resolution. quality: 1 to 100. Throws
// std::invalid_argument for other types and empty images.
std::vector<std::uint8_t> EncodeJpeg(const cv::Mat& image, int quality);

}  // namespace highwall
