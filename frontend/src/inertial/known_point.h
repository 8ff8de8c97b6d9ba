#pragma once

#include <memory>

#include <highwall/core/pose.h>
#include <highwall/factors/point_in_frame.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/map/seen_landmarks.h>

namespace highwall {

// Returns the observations of a point by the map's keyframes as one Gaussian of its position in W:
// their rows linearized at the map's position, outliers down-weighted as by a Huber loss of that
// width [sigma]. T_WM: pose of the map's world. Unobservable directions remain unconstrained.
std::unique_ptr<PointInFrame> KnownPoint(const SeenLandmark<MapPoint>& seen, const Pose& T_WM,
                                         const MeasurementModel& model, double huber);

}  // namespace highwall
