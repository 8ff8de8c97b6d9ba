#pragma once

#include <optional>

#include <highwall/core/pose.h>
#include <highwall/frontend/system/slam_system.h>

namespace highwall::apps {

// The frame O of the odometry: in it the camera moves without jumps, since a correction of the map
// moves O in the world instead. O is the world W until the first correction.
class OdometryFrame {
 public:
  // Takes the pose of a frame that has one, T_WC, and returns T_OC. `slam` is in the state in which
  // it reported the frame: the motion since the frame before is measured in the map as it is now.
  // Where the two are in different worlds, the motion is unknown and taken as none.
  Pose Advance(const FrameResult& result, const Map& map);
  // T_WO, by the last frame.
  const Pose& T_WO() const { return T_WO_; }

 private:
  // Returns T_WC of the last frame in the world as it is now; empty if it is in another one.
  std::optional<Pose> LastIn(SubmapId world, const Map& map) const;

  struct Last {
    KeyFrameId anchor = kNoId;  // keyframe of its world
    Pose T_AC;                  // relative to that keyframe
    Pose T_OC;
  };
  std::optional<Last> last_;
  KeyFrameId anchor_ = kNoId;
  Pose T_WO_;
};

}  // namespace highwall::apps
