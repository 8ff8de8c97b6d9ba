#pragma once

#include <optional>
#include <vector>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_solver.h>

namespace highwall {

// The form in which SolvePose takes a kind of landmark, and its inliers.
template <class Landmark>
struct PoseTraits;
template <>
struct PoseTraits<MapPoint> {
  using Observation = PosePoint;
  static const std::vector<bool>& Inliers(const PoseSolution& solution) {
    return solution.point_inliers;
  }
};
template <>
struct PoseTraits<MapLine> {
  using Observation = PoseLine;
  static const std::vector<bool>& Inliers(const PoseSolution& solution) {
    return solution.line_inliers;
  }
};
// Observations of one kind; PerKind<PoseObservations> are those of an image.
template <class Landmark>
using PoseObservations = std::vector<typename PoseTraits<Landmark>::Observation>;

// Returns a landmark and its feature in the form used by SolvePose.
PosePoint MakePoseObservation(const MeasurementModel& model, const MapPoint& point,
                              const PointFeature& feature);
// T_WC: rough pose of the camera, which determines the part of the map line that the feature
// observes. Empty if that part is not in front of the camera; never empty for a point.
std::optional<PosePoint> MakePoseObservation(const MeasurementModel& model, const MapPoint& point,
                                             const PointFeature& feature, const Pose& T_WC);
std::optional<PoseLine> MakePoseObservation(const MeasurementModel& model, const MapLine& line,
                                            const LineFeature& feature, const Pose& T_WC);

}  // namespace highwall
