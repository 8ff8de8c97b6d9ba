#pragma once

#include <map>
#include <optional>
#include <span>

#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/map.h>

#include "features/depth_grid.h"
#include "features/row_times.h"

namespace highwall {

// Stores the rolling-shutter compensation of each keyframe, so that its features can be updated
// when the estimate of the timing or of the motion improves (docs/row_times.md).
class KeyframeRowTimes {
 public:
  // camera, grid: as those of MovedOtherwise; grid must outlive it.
  KeyframeRowTimes(const PinholeCamera& camera, const DepthGrid& grid)
      : camera_(camera), grid_(grid) {}

  void Remember(const KeyFrame& keyframe, const RowMotion& moved_by);
  // Updates the motion of the camera at a keyframe with a better estimate. Ignores unknown
  // keyframes.
  void Correct(KeyFrameId id, const Twist& motion);
  // The same by the readings of an IMU, which count until they are forgotten.
  void CorrectByReadings(KeyFrameId id, const Twist& motion);
  void ForgetReadings();
  // Returns null for an unknown keyframe, such as one of another run.
  const RowMotion* Find(KeyFrameId id) const;

  // Moves the features of these keyframes if the change of the timing or of their motion is
  // significant, and the landmarks made of them by the share that these keyframes have in them. A
  // change within the estimate's own sigma moves nothing. The poses are left to the adjustment that
  // follows: keyframes that no adjustment is about to move must not be passed, because their
  // features and landmarks are already consistent.
  void Compensate(const FrameTimingEstimate& timing, std::span<const KeyFrameId> keyframes,
                  Map* map);

 private:
  struct Known {
    RowMotion moved_by;
    Twist motion;
    double depth;                        // [m] of its scene
    std::optional<Twist> by_readings{};  // its motion
  };
  // Removes keyframes that the map has removed, from time to time.
  void Forget(const Map& map);

  PinholeCamera camera_;  // without distortion
  const DepthGrid& grid_;
  std::map<KeyFrameId, Known> keyframes_;
};

}  // namespace highwall
