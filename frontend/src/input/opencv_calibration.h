#pragma once

#include <highwall/frontend/input/sensor.h>

#include "input/foreign_map.h"

namespace highwall {

// Reads the result of a calibration by OpenCV, as its samples write it in YAML or XML: image_width,
// image_height, camera_matrix, distortion_coefficients and fisheye_model. Throws IoError naming the
// file, the line and the key.
SensorCalibration ReadOpencvCalibration(const ForeignMap& file);

// Reads a camera_info of ROS in the form of camera_calibration (image_width, camera_matrix) or of a
// message (width, K). Images are taken for those of the camera, not for rectified ones: the matrix
// is K, not P. Throws as above.
SensorCalibration ReadCameraInfoFile(const ForeignMap& file);

}  // namespace highwall
