#pragma once

#include <Eigen/Core>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

// Returns what two keyframes know of the pose of one relative to the other: the information
// [1/m^2, 1/rad^2] of a translation and a rotation along the axes of the camera of `keyframe`, by
// the landmarks that both observe, each marginalized, with the stated noise. Directions that they
// leave open have none. Throws InvalidArgument if one is not in the map.
Eigen::Matrix<double, 6, 6> RelativeInformation(const Map& map, const MeasurementModel& model,
                                                KeyFrameId reference, KeyFrameId keyframe);

}  // namespace highwall
