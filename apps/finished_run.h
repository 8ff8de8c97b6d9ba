#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/map.h>

namespace highwall::apps {

// Whether images of both can be in one map: distortion aside, which features are without.
bool IsSameCamera(const PinholeCamera& a, const PinholeCamera& b);

struct AnchoredFrame {
  Stamp stamp = 0;
  AnchoredPose pose;  // relative to a keyframe of the run's map
};

// The frames that one camera has taken, one after the other.
struct Session {
  std::string name;                   // of its run's folder or map
  std::vector<AnchoredFrame> frames;  // of a world each in the order of time
  std::size_t left_out = 0;           // frames of a world that has no keyframe of the session
};

// What a run has left: its map, and its frames, which follow the keyframes of that.
struct FinishedRun {
  std::filesystem::path path;  // as it was given
  SavedMap saved;
  DepthNoise depth_noise;
  std::vector<Session> sessions;  // several where it is of runs that were merged
};

// run.json of a finished run, or of runs that were merged. Throws IoError where there is none, or
// it is damaged.
nlohmann::json ReadReport(const std::filesystem::path& folder);

// path: the folder of `highwall slam --out` or `highwall merge --out`, or a map that --save-map
// wrote, whose frames are its keyframes. Throws IoError where it is neither, or has no map.
FinishedRun ReadFinishedRun(const std::filesystem::path& path);

// The frames of one world relative to keyframes of the map: each to the one among them that is
// nearest in time (the earlier of two). Of keyframes with the stamp of a frame, that which has its
// pose is the frame itself: a map may hold those of other sessions. Empty where there is none.
std::vector<AnchoredFrame> AnchorFrames(const Trajectory& frames, const Map& map);

}  // namespace highwall::apps
