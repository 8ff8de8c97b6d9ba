#pragma once

#include <span>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "local/agreeing_views.h"
#include "local/triangulation_options.h"

namespace highwall {

// Returns whether the depth of a corner is accurate enough for a landmark by itself.
bool HasSoundDepth(const PointFeature& feature, double max_depth_sigma);

// Triangulates corners of keyframe `id` that have neither accurate depth nor a landmark, matched
// with corners of neighbouring keyframes without a landmark. Returns points on which min_views
// agree and whose distance has a relative sigma of at most max_depth_sigma. inliers: bounds of
// agreeing views.
std::vector<Depthless<MapPoint>> FindDepthlessPoints(const MeasurementModel& model, const Map& map,
                                                     KeyFrameId id,
                                                     std::span<const KeyFrameId> neighbours,
                                                     const TriangulationOptions& options,
                                                     const InlierBounds& inliers);

}  // namespace highwall
