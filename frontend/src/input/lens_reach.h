#pragma once

#include <highwall/core/camera.h>

namespace highwall {

// Returns the squared distance from the axis, at z = 1, of the farthest ray of the image's border.
// Beyond it a model of a lens may fold rays back into the image. camera: valid.
double SquaredReach(const PinholeCamera& camera);

}  // namespace highwall
