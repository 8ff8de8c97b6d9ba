#pragma once

#include <memory>
#include <optional>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/map/anchored_pose.h>

namespace highwall {

// The pose of a frame as its image states it, in its world: of the camera, or of the body of an
// IMU.
struct MeasuredPose {
  Stamp stamp = 0;
  Pose T_WB;
  std::optional<ImageInformation> information{};      // as in PosedFrame, in B
  std::shared_ptr<const ReadingsBetween> readings{};  // since the pose before
};

}  // namespace highwall
