#pragma once

#include <Eigen/Geometry>

namespace highwall::simulate {

// Camera axes (x right, y down, z forward) looking along yaw and pitch [rad], turned by roll.
Eigen::Quaterniond Look(double yaw, double pitch, double roll);

}  // namespace highwall::simulate
