#pragma once

#include <highwall/frontend/map/map_ids.h>

namespace highwall {

// A stage of SLAM that computes on a copy of the map, synchronously or on a thread of its own, and
// edits the map with its result between two frames. MapWorker decides whose work remains valid as
// the map changes.
class MapStage {
 public:
  virtual ~MapStage() = default;

  // Returns whether there is neither work in progress nor a result that is yet to be applied.
  virtual bool IsIdle() const = 0;
  // A submap of the world that the work concerns; kNoId if the stage is idle.
  virtual SubmapId submap() const = 0;
  // Discards the work in progress, because the map moves under it. Waits for
  // the current iteration at most.
  virtual void Drop() = 0;
  // Forgets what the stage has learnt about the positions of keyframes beside its work.
  virtual void Forget() {}

 protected:
  MapStage() = default;
  MapStage(const MapStage&) = default;
  MapStage& operator=(const MapStage&) = default;
};

}  // namespace highwall
