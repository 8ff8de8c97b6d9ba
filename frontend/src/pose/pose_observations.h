#pragma once

#include <optional>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_solver.h>

namespace highwall {

// Returns a landmark and its feature in the form used by SolvePose.
PosePoint MakePosePoint(const MeasurementModel& model, const MapPoint& point,
                        const PointFeature& feature);

// T_WC: rough pose of the camera, which determines the part of the map line that the feature
// observes. Empty if that part is not in front of the camera.
std::optional<PoseLine> MakePoseLine(const MeasurementModel& model, const MapLine& line,
                                     const LineFeature& feature, const Pose& T_WC);

}  // namespace highwall
