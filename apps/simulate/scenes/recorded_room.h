#pragma once

#include "simulate/camera/simulation.h"
#include "simulate/motion/recorded_motion.h"

namespace highwall::simulate {

// Returns the orientation of a camera that looks horizontally ahead: along the body axis after the
// one that pointed up most of the time. Its position on the body is the lever arm of
// options.imu.T_BC.
Eigen::Quaterniond LevelCamera(const RecordedMotion& motion);

// Simulates the room of options.seed along a recorded motion, with the recorded readings. The
// motion is moved to the middle of the room, and the room is enlarged (factor at least 1) until the
// motion does not collide with its furniture. options.duration: limited to that of the motion.
// options.imu: the rotation of T_BC becomes LevelCamera(); noise is that of the calibration. Throws
// InvalidArgument.
Simulation SimulateRecordedRoom(const RecordedMotion& motion, SimulationOptions options);

}  // namespace highwall::simulate
