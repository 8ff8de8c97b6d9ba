#pragma once

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/map/map.h>

namespace highwall::apps {

// Returns the part of a run's map that belongs to the world of its trajectory, for drawing:
//   "keyframes": {"stamp", "position" [m], "rotation" (x y z w)}: T_WC of each
//   "covisible": [i, j, landmarks]: pairs of indices into "keyframes" with common landmarks,
//                for each keyframe only the few with most common landmarks
//   "lines": base64 of float32, two ends [m] of each line; "line_count", "points": counts
// trajectory: T_WC of the frames. An empty object if no frame is a keyframe.
nlohmann::json GraphJson(const Map& map, const Trajectory& trajectory);

// Returns `events` of run.json with the positions [m] "from" (of the newer keyframe) and "to", even
// if those were culled later, and their times "t" and "t_match" [s] after `start`; null if they are
// not in this trajectory or not in this run.
nlohmann::json LoopsJson(const Trajectory& trajectory, Stamp start, const nlohmann::json& events);

}  // namespace highwall::apps
