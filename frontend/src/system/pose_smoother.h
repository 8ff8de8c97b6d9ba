#pragma once

#include <span>
#include <vector>

#include "system/measured_pose.h"

namespace highwall {

// Returns the poses of a world with each held by its image and by its neighbours in time: a factor
// graph of measured poses and of white noise on the acceleration between them (WhiteAcceleration),
// whose densities it estimates from the poses themselves. Poses without information stay as they
// are; across gaps nothing holds. Linear in the number of poses, in windows of bounded memory.
// poses: by stamp. (docs/tracking.md, Smoothing)
std::vector<Pose> SmoothPoses(std::span<const MeasuredPose> poses);

}  // namespace highwall
