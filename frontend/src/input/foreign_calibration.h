#pragma once

#include <filesystem>
#include <optional>

#include <highwall/frontend/input/sensor.h>

namespace highwall {

// Reads the calibration of another system, which is recognized by its content: ORB-SLAM, OpenCV,
// a camera_info of ROS, Kalibr, Open3D. Empty for a calibration.yaml, for an unknown format and for
// a path that is no file. Throws IoError for one that cannot be used, and for a format that is
// recognized but not read, with how to write it for Highwall.
std::optional<SensorCalibration> ReadForeignCalibration(const std::filesystem::path& path);

}  // namespace highwall
