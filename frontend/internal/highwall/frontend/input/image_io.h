#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <opencv2/core/mat.hpp>

// Image readers that, unlike cv::imread, report a truncated file as an error instead of returning a
// picture with a grey lower half.
namespace [[gnu::visibility("default")]] highwall {

// Reads CV_8UC3 BGR, ignoring orientation tags. Data that a camera adds behind the end of a JPEG is
// ignored, and so is a missing end marker. Throws IoError if the file is missing, truncated or not
// an image.
cv::Mat ReadColourImage(const std::filesystem::path& path);

// Reads CV_8UC1, ignoring orientation tags. Throws as above.
cv::Mat ReadGreyImage(const std::filesystem::path& path);

// Reads an image as stored, in any pixel type. Throws as above.
cv::Mat ReadStoredImage(const std::filesystem::path& path);

// Reads the stored 16-bit values, CV_16UC1. Throws as above, and for any other pixel type.
cv::Mat ReadDepthImage(const std::filesystem::path& path);

// Decode the bytes of such a file, at least one. path: for messages.
cv::Mat DecodeColourImage(const std::filesystem::path& path,
                          const std::vector<std::uint8_t>& bytes);
cv::Mat DecodeDepthImage(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes);

}  // namespace highwall
