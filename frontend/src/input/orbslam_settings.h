#pragma once

#include <highwall/frontend/input/sensor.h>

#include "input/foreign_camera.h"
#include "input/foreign_map.h"

namespace highwall {

// Reads a settings file of ORB-SLAM2 (Camera.fx) or ORB-SLAM3 (Camera1.fx): camera, lens (PinHole,
// Rectified, KannalaBrandt8), depth factor, and of an IMU T_BC (Tbc, IMU.T_b_c1), noise and rate.
// image_size: asked where the file does not state the size of the images, as those of ORB-SLAM2;
// may be empty. Throws IoError naming the file, the line and the key.
SensorCalibration ReadOrbSlamSettings(const ForeignMap& file, const ImageSizeSource& image_size);

}  // namespace highwall
