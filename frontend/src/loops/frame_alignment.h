#pragma once

#include <optional>

#include <highwall/core/pose.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

// T_FW of a frame of the user's in the world of a submap, by all that was measured in it, with the
// keyframes as they are; empty as long as that does not tell its heading to max_angle [rad], one
// sigma, or, where it is not upright, its rotation about any axis.
std::optional<Pose> AlignFrame(const Map& map, ReferenceFrameId frame, SubmapId submap,
                               double max_angle);

}  // namespace highwall
