#pragma once

#include <optional>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "pose/pose_solver.h"

namespace highwall {

// A landmark and the feature that observes it, as SolvePose takes them.
PosePoint MakePosePoint(const MeasurementModel& model, const MapPoint& point,
                        const PointFeature& feature);

// T_WC: rough pose of the camera, which tells what piece of the map line the feature sees. Empty
// where that piece is not in front of the camera.
std::optional<PoseLine> MakePoseLine(const MeasurementModel& model, const MapLine& line,
                                     const LineFeature& feature, const Pose& T_WC);

}  // namespace highwall
