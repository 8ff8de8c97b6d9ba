#pragma once

#include <memory>

#include <highwall/core/pose.h>
#include <highwall/factors/point_in_frame.h>
#include <highwall/frontend/map/measurement_model.h>

#include "map/seen_landmarks.h"

namespace highwall {

// What the map's keyframes saw of a point as one Gaussian of where it lies in W: their rows about
// where the map has it, an outlier of them weighed down as by a Huber loss of that width [sigma].
// T_WM: where the map's world lies. A direction that they leave open stays open.
std::unique_ptr<PointInFrame> KnownPoint(const SeenPoint& seen, const Pose& T_WM,
                                         const MeasurementModel& model, double huber);

}  // namespace highwall
