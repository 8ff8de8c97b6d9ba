#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/keyframe_event.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/pose/pose_report.h>
#include <highwall/mapping/depth_camera.h>

// Data of the blocks of a scene (docs/view.md).
namespace highwall::apps {

// A frame of the run. Its position is relative to a keyframe, so that it follows the corrections of
// the map.
struct FrameRecord {
  double seconds = 0.0;  // since the first frame
  TrackingState state = TrackingState::kLost;
  std::int32_t anchor = -1;                              // keyframe; -1: no pose
  Eigen::Vector3f p_K = Eigen::Vector3f::Zero();         // [m] position of the camera in the anchor
  int points = 0, lines = 0;                             // matched
  float features = 0, pose = 0, mapping = 0, total = 0;  // [ms]
  float weight = -1;                                     // of the IMU factor; negative: none
};

// A keyframe, also one that was culled, since frames are relative to it.
struct KeyframeRecord {
  std::int32_t id = -1;
  std::int32_t world = -1;  // -1: removed with its submap
  bool active = false;
  Pose T_WC{};
};

// A closed or rejected loop between two keyframes.
struct LoopRecord {
  std::int32_t from = -1, to = -1;
  bool accepted = false, merged = false;
};

// Points of a keyframe in its own frame, a uniform sample of its depth image in random order: the
// first of them are a uniform sample too.
struct KeyframeCloudSample {
  std::int32_t id = -1;
  std::vector<Eigen::Vector3f> points_C{};  // [m]
  std::vector<std::uint8_t> rgb{};          // three for each
};

// Returns at most `limit` points with a depth in the range [m]. Empty without a depth image.
KeyframeCloudSample SampleKeyframe(const KeyframeView& view, const DepthUnprojector& unprojector,
                                   float min_depth, float max_depth, std::size_t limit);

// first: index of the first record in the run.
std::string FramesBlock(std::size_t first, std::span<const FrameRecord> frames);
std::string KeyframesBlock(std::span<const KeyframeRecord> keyframes);
std::string LoopsBlock(std::span<const LoopRecord> loops);
std::string CloudBlock(const KeyframeCloudSample& sample);
// A cube of the octree: corner is its lowest cell in units of the edge of a cell [m], cells are
// indices x + side (y + side z) of the occupied ones.
std::string OctreeBlock(std::int32_t world, double size, const Eigen::Vector3i& corner, int side,
                        std::span<const std::uint16_t> cells);

}  // namespace highwall::apps
