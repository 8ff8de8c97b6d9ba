#pragma once

#include <span>
#include <string_view>

#include <highwall/core/camera.h>

namespace highwall {

// Sets the lens of a camera from the coefficients of a model that ROS, Kalibr or a RealSense names,
// in the order of OpenCV; an empty name is that of the radial-tangential model. Coefficients beyond
// those of PinholeCamera are left out. Returns false, and leaves the lens, for a model that is not
// known and bends rays.
bool SetLens(std::string_view model, std::span<const double> coefficients, PinholeCamera* camera);

// Whether coefficients beyond the eight of PinholeCamera are not zero: those of a thin prism or of
// a tilted sensor.
bool HasUnknownCoefficients(std::span<const double> coefficients);

}  // namespace highwall
