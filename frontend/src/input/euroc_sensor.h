#pragma once

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/input/sensor.h>

#include "input/foreign_map.h"

// The files sensor.yaml of EuRoC, one beside the data of each sensor. B is the body that they refer
// to. Each function throws IoError naming the file, the line and the key. Source: Burri et al.,
// "The EuRoC micro aerial vehicle datasets", IJRR 35(10), 2016.
namespace highwall {

// Returns the camera of the images: pinhole, with a radial-tangential or an equidistant lens.
PinholeCamera ReadEurocCamera(const ForeignMap& file);
// Returns T_BS, the pose of the sensor in B.
Pose ReadEurocPose(const ForeignMap& file);
// Returns the IMU with the noise and the rate that the file states. T_BC: pose of the camera in B.
ImuCalibration ReadEurocImu(const ForeignMap& file, const Pose& T_BC);

// Returns the calibration by the file of a camera and, if it exists, ../imu0/sensor.yaml beside it.
// Without the latter T_BC is the camera's T_BS: B is the IMU in EuRoC's recordings.
SensorCalibration ReadEurocSensor(const ForeignMap& file);

}  // namespace highwall
