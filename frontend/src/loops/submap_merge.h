#pragma once

#include <optional>
#include <string>

#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>

#include "pose/depth_agreement.h"

namespace highwall {

// How the two submaps of a loop come into one world frame. The frame of the older one stays, unless
// only the other knows gravity; where both do, what moves is turned about the vertical alone. Empty
// where the loop would tilt gravity by more than its own error explains; `message` then says so.
// loop: between keyframes of submaps that are not joined.
std::optional<SubmapMerge> PlanMerge(const Map& map, const LoopEdge& loop,
                                     const KeyFrameGraphOptions& options, std::string* message);

// What the depth of the two submaps, all of it that overlaps, says against the merge: the share
// that is contradicted (DepthComparison); empty where little overlaps.
std::optional<double> MergeContradiction(const Map& map, const SubmapMerge& merge,
                                         const DepthGrid& grid, const DepthNoise& noise);

// Moves one of the two into the world of the other, and joins them.
void Apply(const SubmapMerge& merge, Map* map);

}  // namespace highwall
