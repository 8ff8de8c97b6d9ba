#pragma once

#include <span>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

#include "local/agreeing_views.h"

namespace highwall {

// Options of triangulating corners and segments without depth, by the parallax between keyframes.
struct TriangulationOptions {
  int keyframes = 10;  // >= 0: neighbours to match against; 0: no triangulation
  // >= 2: keyframes that must agree, since two alone agree by chance; for a line at least three,
  // since two planes through segments always intersect in one.
  int min_views = 3;
  // >= 0: segments only if a keyframe was tracked by fewer points; with many points they are too
  // few to help (docs/lines.md).
  int scarce_points = 100;
  // > 0, relative to its depth: a less certain one waits for more parallax
  double max_depth_sigma = 0.1;
};

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
