#pragma once

#include <span>
#include <vector>

#include <highwall/core/line3.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "local/triangulation_options.h"

namespace highwall {

// A line observed by several keyframes, all without depth.
struct DepthlessLine {
  Segment3 segment_W;                     // [m] as observed by the newest keyframe
  std::vector<Observation> observations;  // that of the newest keyframe first
};

// Triangulates segments of keyframe `id` that have neither depth nor a landmark, matched with such
// segments of neighbouring keyframes. Returns lines on which options.min_views of them, three at
// least, agree and whose ends' distances have a relative sigma of at most max_depth_sigma. inliers:
// bounds of agreeing views.
std::vector<DepthlessLine> FindDepthlessLines(const MeasurementModel& model, const Map& map,
                                              KeyFrameId id, std::span<const KeyFrameId> neighbours,
                                              const TriangulationOptions& options,
                                              const InlierBounds& inliers);

}  // namespace highwall
