#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "sensor/imu_alignment.h"

namespace highwall {

// Returns the scales of images that are tried where any one excuses the IMU: 1/16 to 16, four an
// octave.
std::vector<double> ScalesOfImages();

// Returns the ratio of the lengths in the images to those that the accelerometer measures, if they
// contradict each other by it: a depth factor that is wrong, or a unit of the accelerometer. Empty
// for a ratio within 1.3, one that is not significant, and where no ratio makes them agree.
//
// A_CB, lever_arm [m]: as configured (AccelerometerFit). Along a line through the configuration the
// squared residuals, in variances, exceed those of the best ratio by chi-squared with one degree of
// freedom, which is above 25 once in two million; what exceeds once in a thousand (11) is doubled
// for errors of poses that last. strictness > 0: factor of this limit; below 1 where what
// contradicts the configuration most has been left out (ImuAlignment::Trim()).
std::optional<double> ContradictedScale(const AccelerometerFit& fit, const Eigen::Matrix3d& A_CB,
                                        const Eigen::Vector3d& lever_arm, double strictness = 1.0);

}  // namespace highwall
