#pragma once

#include <filesystem>

#include <highwall/frontend/input/sensor.h>

namespace highwall {

// Reads camera_intrinsic.json of Open3D: width, height, intrinsic_matrix (column by column) and,
// where it exists, depth_scale (otherwise depth is in millimetres). Throws IoError naming the file
// for another form.
SensorCalibration ReadOpen3dIntrinsic(const std::filesystem::path& path);

}  // namespace highwall
