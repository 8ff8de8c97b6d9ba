#pragma once

#include <Eigen/Core>

#include <highwall/core/pose.h>

namespace highwall {

// Returns the rotation about z and the translation that are nearest to a rigid motion at the point
// p [m]: the motion allowed for a world whose z axis points up.
Pose YawAndShift(const Pose& T, const Eigen::Vector3d& p);

}  // namespace highwall
