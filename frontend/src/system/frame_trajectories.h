#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/system/slam_system.h>

#include "system/measured_pose.h"

namespace highwall {

// The poses of the tracked frames, which follow the keyframes they are anchored to, and the worlds
// in which they were tracked.
class FrameTrajectories {
 public:
  // Adds the newest frame. submap: of the active keyframe that it is anchored to.
  void Add(const PosedFrame& frame, SubmapId submap);
  // Adds frames that were found later, ascending by stamp; none has the stamp of another one.
  void Insert(const std::vector<PosedFrame>& found, const Map& map);
  // Removes the frames of a submap that was removed from the map.
  void Forget(SubmapId submap, const Map& map);

  // All of them, by stamp.
  const std::vector<PosedFrame>& frames() const { return frames_; }
  // For poses that are refined later.
  std::vector<PosedFrame>* mutable_frames() { return &frames_; }

  // Predicts the pose of the newest frame at its stamp from the images of the frames before
  // (PredictLastPose), for one whose image is older than its stamp or repeats another. Returns
  // T_WC; empty if there are too few.
  std::optional<Pose> PredictNewest(const Map& map) const;

  // Smooths the poses of each world over time (SmoothPoses), for ByWorld(), which then has
  // velocities as well; frames() stay as they were measured. T_BC: of the camera on the IMU, where
  // there is one.
  void Smooth(const Map& map, const std::optional<Pose>& T_BC);

  // Returns the root of the world in which most frames were tracked; empty if there is none.
  std::optional<SubmapId> LargestWorld(const Map& map) const;
  std::size_t MemoryBytes() const;
  // Returns SlamSystem::submaps().
  std::vector<SubmapTrajectory> ByWorld(const Map& map) const;

 private:
  std::vector<PosedFrame> frames_;
  // A frame after smoothing. Its velocity is along the axes of the camera, so that it turns with
  // the world of its keyframe.
  struct Smoothed {
    AnchoredPose pose;
    std::optional<BodyVelocity> of_C{};
  };
  std::vector<Smoothed> smoothed_;             // of the first frames; empty before Smooth()
  std::map<SubmapId, std::size_t> number_in_;  // number of frames, by the submap of their keyframe
};

}  // namespace highwall
