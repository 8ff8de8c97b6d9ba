#pragma once

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/map/map.h>

namespace highwall::apps {

// What the map of a run holds of the world of its trajectory, for drawing:
//   "keyframes": {"stamp", "position" [m], "rotation" (x y z w)}: T_WC of each
//   "covisible": [i, j, landmarks]: pairs of places in "keyframes" that see landmarks in common,
//                of each keyframe the few that it has most with
//   "lines": base64 of float32, two ends [m] of each line; "line_count", "points": how many
// trajectory: T_WC of the frames. An empty object where no keyframe is of them.
nlohmann::json GraphJson(const Map& map, const Trajectory& trajectory);

// `events` of run.json with the positions [m] "from" (of the newer keyframe) and "to", also where
// they were culled since, and their times "t" and "t_match" [s] after `start`; null where they are
// not of this trajectory, or not of this run.
nlohmann::json LoopsJson(const Trajectory& trajectory, Stamp start, const nlohmann::json& events);

}  // namespace highwall::apps
