#pragma once

#include <filesystem>

#include <highwall/frontend/input/sensor.h>

#include "input/foreign_map.h"

namespace highwall {

// Reads camera_intrinsic.json of Open3D: width, height, intrinsic_matrix (column by column) and,
// where it exists, depth_scale (otherwise depth is in millimetres). Throws IoError naming the file
// for another form.
SensorCalibration ReadOpen3dIntrinsic(const std::filesystem::path& path);

// Reads the same as a calibration that is given to a recording of another format: its defaults are
// SensorCalibration::defaults.
SensorCalibration ReadOpen3dIntrinsic(const ForeignMap& file);

}  // namespace highwall
