#pragma once

#include <algorithm>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/system/slam_system.h>

namespace highwall::apps {

// The keyframes of the map that a run has loaded; none if there is no such map.
class LoadedMap {
 public:
  explicit LoadedMap(const Map& map) : keyframes_(map.keyframe_ids()) {}

  // Returns whether a world of `map`, which has grown from it, holds any of them.
  bool IsIn(SubmapId world, const Map& map) const {
    return std::ranges::any_of(keyframes_, [&](KeyFrameId id) { return map.RootOf(id) == world; });
  }
  // Returns the submaps with the worlds of the loaded map first, each kind in its order.
  std::vector<SubmapTrajectory> First(std::vector<SubmapTrajectory> submaps, const Map& map) const {
    const auto is_loaded = [&](const SubmapTrajectory& submap) { return IsIn(submap.submap, map); };
    std::stable_partition(submaps.begin(), submaps.end(), is_loaded);
    return submaps;
  }
  // Returns whether a run of this largest world has met the map; true if there was none.
  bool IsMet(SubmapId largest, const Map& map) const {
    return keyframes_.empty() || IsIn(largest, map);
  }
  // Returns the keyframes of a world that are not among them.
  Trajectory NewKeyFrames(SubmapId world, const Map& map) const {
    Trajectory trajectory;
    for (const KeyFrameId id : map.KeyFramesOf(world)) {
      if (!keyframes_.empty() && id <= keyframes_.back()) continue;
      trajectory.push_back({map.keyframe(id)->frame.stamp, map.keyframe(id)->T_WC});
    }
    return trajectory;
  }

 private:
  std::vector<KeyFrameId> keyframes_;  // ascending
};

}  // namespace highwall::apps
