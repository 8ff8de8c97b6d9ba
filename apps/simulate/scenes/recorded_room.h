#pragma once

#include "simulate/camera/simulation.h"
#include "simulate/motion/recorded_motion.h"

namespace highwall::simulate {

// A camera that looks level and ahead: along the body axis after the one that was up most of the
// time. Where on the body it sits is options.imu.T_BC's lever arm.
Eigen::Quaterniond LevelCamera(const RecordedMotion& motion);

// The room of options.seed, filmed along a recorded motion, with the recorded readings: the motion
// is moved to the middle of the room, and the room is as many times as large (at least 1) as keeps
// the motion off its furniture. options.duration: shortened to what the motion has. options.imu:
// T_BC's rotation becomes LevelCamera(); noise is that of the calibration. Throws InvalidArgument.
Simulation SimulateRecordedRoom(const RecordedMotion& motion, SimulationOptions options);

}  // namespace highwall::simulate
