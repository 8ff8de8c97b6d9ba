#pragma once

#include <map>
#include <span>

#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/map.h>

#include "features/depth_grid.h"
#include "features/row_times.h"

namespace highwall {

// What the rows of each keyframe's image were moved by, so that they follow when timing or motion
// are known better (docs/row_times.md).
class KeyframeRowTimes {
 public:
  // camera, grid: as of MovedOtherwise; grid must outlive it.
  KeyframeRowTimes(const PinholeCamera& camera, const DepthGrid& grid)
      : camera_(camera), grid_(grid) {}

  void Remember(const KeyFrame& keyframe, const RowMotion& moved_by);
  // The motion of the camera at a keyframe, as it is known by now. Others are left alone.
  void Correct(KeyFrameId id, const Twist& motion);
  // Nothing where it is not known: a keyframe of another run.
  const RowMotion* Find(KeyFrameId id) const;

  // Moves the features of these keyframes where the timing or their corrected motion shows, and the
  // landmarks made of them, as far as these keyframes have a say in them. An estimate that has
  // wandered within its own sigma moves nothing. Their poses are left to the adjustment that
  // follows: of keyframes that none is about to move, features and landmarks fit as they are.
  void Retime(const FrameTimingEstimate& timing, std::span<const KeyFrameId> keyframes, Map* map);

 private:
  struct Known {
    RowMotion moved_by;
    Twist motion;
    double depth;  // [m] of its scene
  };
  // Those that were removed from the map, now and then.
  void Forget(const Map& map);

  PinholeCamera camera_;  // without distortion
  const DepthGrid& grid_;
  std::map<KeyFrameId, Known> keyframes_;
};

}  // namespace highwall
