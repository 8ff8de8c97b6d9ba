#pragma once

#include <Eigen/Core>

#include <highwall/core/pose.h>

namespace highwall {

// The turn about z and the shift that are nearest to a rigid motion at the point p [m]: how a world
// whose z axis points up may be moved.
Pose YawAndShift(const Pose& T, const Eigen::Vector3d& p);

}  // namespace highwall
