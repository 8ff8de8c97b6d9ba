#pragma once

#include <highwall/frontend/input/dataset.h>

namespace [[gnu::visibility("default")]] highwall {

// Returns [s] by which the stamp of its depth is later; 0 if it is so large that the motion of the
// camera in between is unknown, or from another clock.
double DepthDelay(const RgbdImage& image);

}  // namespace highwall
