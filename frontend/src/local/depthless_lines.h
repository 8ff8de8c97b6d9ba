#pragma once

#include <span>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "local/agreeing_views.h"
#include "local/triangulation_options.h"

namespace highwall {

// Triangulates segments of keyframe `id` that have neither depth nor a landmark, matched with such
// segments of neighbouring keyframes. Returns lines on which options.min_views of them, three at
// least, agree and whose ends' distances have a relative sigma of at most max_depth_sigma. inliers:
// bounds of agreeing views.
std::vector<Depthless<MapLine>> FindDepthlessLines(const MeasurementModel& model, const Map& map,
                                                   KeyFrameId id,
                                                   std::span<const KeyFrameId> neighbours,
                                                   const TriangulationOptions& options,
                                                   const InlierBounds& inliers);

}  // namespace highwall
