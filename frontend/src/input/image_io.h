#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

// Images read with the care that cv::imread does not take: a file that was cut short is an error
// instead of a picture with a grey lower half.
namespace highwall {

// CV_8UC3 BGR, orientation tags ignored. What a camera adds behind the end of a JPEG does not
// matter, nor that the end marker is missing. Throws IoError if the file is missing, truncated or
// not an image.
cv::Mat ReadColourImage(const std::filesystem::path& path);

// The stored 16-bit values, CV_16UC1. Throws as above, and for any other pixel type.
cv::Mat ReadDepthImage(const std::filesystem::path& path);

}  // namespace highwall
