#pragma once

#include <optional>
#include <string>

namespace highwall::apps {

// Of the text of a calibration that another system wrote (ORB-SLAM, ROS, Kalibr, EuRoC, Open3D,
// librealsense, OpenCV): whose it is, and how the same is written here. Empty for one of ours, and
// for what is not known.
std::optional<std::string> DescribeForeignCalibration(const std::string& text);

}  // namespace highwall::apps
