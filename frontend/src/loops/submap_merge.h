#pragma once

#include <optional>
#include <string>

#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>

#include "pose/depth_agreement.h"

namespace highwall {

// Plans the merge of the two submaps of a loop into one world frame. The frame of the older one
// stays, unless only the other knows gravity; if both do, the moved one is rotated about the
// vertical alone. Empty if the loop would tilt gravity by more than its error explains, which
// `message` then says. loop: between keyframes of unconnected submaps.
std::optional<SubmapMerge> PlanMerge(const Map& map, const LoopEdge& loop,
                                     const KeyFrameGraphOptions& options, std::string* message);

// Returns the squared Mahalanobis distance (6 degrees of freedom) between the transforms that two
// loops between the same two unconnected submaps measure, each with the error of a loop
// (CovarianceOf). Throws as Map::ResolvePose.
double MergeChi2(const Map& map, const LoopEdge& before, const LoopEdge& now,
                 const KeyFrameGraphOptions& options);

// Returns the share of overlapping depth of the two submaps that contradicts the merge
// (DepthComparison); empty if the overlap is small.
std::optional<double> MergeContradiction(const Map& map, const SubmapMerge& merge,
                                         const DepthGrid& grid, const DepthNoise& noise);

// Moves one of the two into the world of the other, and merges them.
void Apply(const SubmapMerge& merge, Map* map);

}  // namespace highwall
