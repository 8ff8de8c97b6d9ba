#pragma once

#include <Eigen/Geometry>

namespace highwall::simulate {

// Returns camera axes (x right, y down, z forward) looking along yaw and pitch [rad], rotated by
// roll.
Eigen::Quaterniond Look(double yaw, double pitch, double roll);

}  // namespace highwall::simulate
