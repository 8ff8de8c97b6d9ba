#pragma once

#include <optional>
#include <string>

namespace highwall {

// Identifies the text of a calibration written by another system (ORB-SLAM, ROS, Kalibr, EuRoC,
// Open3D, librealsense, OpenCV) and describes how to write it for Highwall. Empty for a Highwall
// calibration and for an unknown format.
std::optional<std::string> DescribeForeignCalibration(const std::string& text);

}  // namespace highwall
