#pragma once

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>

#include "simulate/camera/simulation.h"

// Images turned clockwise by a quarter, as a phone that is held upright stores those of its sensor,
// whose rows are then columns, read from right to left.
namespace highwall::simulate {

// The pose of the camera of the turned images in the frame of the camera of the images before.
Pose PortraitPose();

// Returns the camera of the turned images.
PinholeCamera Portrait(const PinholeCamera& camera);

// Returns the options with the calibration of the turned images: of both cameras and of the IMU.
SimulationOptions Portrait(SimulationOptions options);

}  // namespace highwall::simulate
