#pragma once

#include <optional>

#include <highwall/core/pose.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

// Returns T_FW of a user reference frame in the world of a submap, by all measurements in it, with
// the current keyframe poses; empty as long as the sigma of its heading or, if it is not upright,
// of its rotation about any axis exceeds max_angle [rad].
std::optional<Pose> AlignFrame(const Map& map, ReferenceFrameId frame, SubmapId submap,
                               double max_angle);

}  // namespace highwall
