#pragma once

#include <optional>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/map/anchored_pose.h>

namespace highwall {

// The pose of a frame as tracking or its refinement estimated it, in its world.
struct MeasuredPose {
  Stamp stamp = 0;
  Pose T_WC;
  std::optional<ImageInformation> information{};  // as in PosedFrame
};

}  // namespace highwall
