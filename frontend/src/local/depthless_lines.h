#pragma once

#include <span>
#include <vector>

#include <highwall/core/line3.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

// A line that several keyframes see and none of them knows the depth of.
struct DepthlessLine {
  Segment3 segment_W;                     // [m] what the newest keyframe saw of it
  std::vector<Observation> observations;  // that of the newest keyframe first
};

// Segments of keyframe `id` without depth that are no landmark yet, found again in neighbouring
// keyframes where they are none either: where options.min_views of them, three at least, agree on a
// line and tell the distance of both its ends to max_depth_sigma, it is returned. inliers: how far
// views may be from it.
std::vector<DepthlessLine> FindDepthlessLines(const MeasurementModel& model, const Map& map,
                                              KeyFrameId id, std::span<const KeyFrameId> neighbours,
                                              const TriangulationOptions& options,
                                              const InlierBounds& inliers);

}  // namespace highwall
