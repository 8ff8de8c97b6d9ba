#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

// Is the depth of a corner so well known that it makes a landmark by itself?
bool HasSoundDepth(const PointFeature& feature, double max_depth_sigma);

// A landmark that several keyframes see and none of them knows the depth of.
struct DepthlessPoint {
  Eigen::Vector3d p_W;                    // [m]
  std::vector<Observation> observations;  // that of the newest keyframe first
};

// Corners of keyframe `id` without sound depth that are no landmark yet, found again in
// neighbouring keyframes where they are none either: where min_views agree on a point and tell its
// distance to max_depth_sigma, it is returned. inliers: of views that agree.
std::vector<DepthlessPoint> FindDepthlessPoints(const MeasurementModel& model, const Map& map,
                                                KeyFrameId id,
                                                std::span<const KeyFrameId> neighbours,
                                                const TriangulationOptions& options,
                                                const InlierBounds& inliers);

}  // namespace highwall
