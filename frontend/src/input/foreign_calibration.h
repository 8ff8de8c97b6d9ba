#pragma once

#include <filesystem>
#include <optional>

#include <highwall/frontend/input/sensor.h>

#include "input/foreign_camera.h"

namespace highwall {

// Reads the calibration of another system, which is recognized by its content: ORB-SLAM, OpenCV,
// a camera_info of ROS, Kalibr, EuRoC, Open3D. Empty for a calibration.yaml, for an unknown format
// and for a path that is no file. Throws IoError for one that cannot be used, and for a format that
// is recognized but not read, with how to write it for Highwall. image_size: asked where the file
// does not state the size of the images; empty: such a file cannot be used.
std::optional<SensorCalibration> ReadForeignCalibration(const std::filesystem::path& path,
                                                        const ImageSizeSource& image_size = {});

}  // namespace highwall
