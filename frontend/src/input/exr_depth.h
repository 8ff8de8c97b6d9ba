#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

namespace highwall {

// Reads the depth of an OpenEXR file: its channel Y, Z or R, CV_32FC1 as stored; values that are
// not finite or not positive become 0. Throws IoError if the file is missing, damaged or has no
// such channel, and always in a build without OpenEXR.
cv::Mat ReadExrDepth(const std::filesystem::path& path);

}  // namespace highwall
