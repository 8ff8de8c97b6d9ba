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

// Whether images of both can share a map: distortion is ignored, because features are undistorted.
bool IsSameCamera(const PinholeCamera& a, const PinholeCamera& b);

struct AnchoredFrame {
  Stamp stamp = 0;
  AnchoredPose pose;  // relative to a keyframe of the run's map
};

// Frames that one camera took consecutively.
struct Session {
  std::string name;                   // of its run's folder or map
  std::vector<AnchoredFrame> frames;  // of each world, ascending in time
  std::size_t left_out = 0;           // frames of worlds without a keyframe of the session
};

// Output of a finished run: its map, and its frames anchored to the map's keyframes.
struct FinishedRun {
  std::filesystem::path path;  // as given
  SavedMap saved;
  DepthNoise depth_noise;
  std::vector<Session> sessions;  // several if runs were merged
};

// Reads run.json of a finished or merged run. Throws IoError if it is missing or damaged.
nlohmann::json ReadReport(const std::filesystem::path& folder);

// path: the folder of `highwall slam --out` or `highwall merge --out`, or a map written by
// --save-map, whose frames are its keyframes. Throws IoError if it is neither, or has no map.
FinishedRun ReadFinishedRun(const std::filesystem::path& path);

// Anchors the frames of one world to the keyframes of the map that are nearest in time (the earlier
// of two). Among keyframes with the stamp of a frame, the one with nearly the same pose is the
// frame itself: a map may contain keyframes of other sessions. Empty if there is no keyframe.
std::vector<AnchoredFrame> AnchorFrames(const Trajectory& frames, const Map& map);

}  // namespace highwall::apps
