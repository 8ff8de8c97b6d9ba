#pragma once

#include <highwall/frontend/input/sensor.h>

#include "input/foreign_map.h"

namespace highwall {

// Reads cam0 of a camera chain of Kalibr (camchain.yaml), T_BC as the inverse of its T_cam_imu, the
// time offset, and the noise of the IMU from a file beside the chain: imu.yaml or, as Kalibr names
// its results, the name of the chain with "imu" for "camchain" or "camchain-imucam". Throws IoError
// naming the file, the line and the key.
SensorCalibration ReadKalibrChain(const ForeignMap& file);

}  // namespace highwall
