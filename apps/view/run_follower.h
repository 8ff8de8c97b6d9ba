#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/system/slam_system.h>
#include <highwall/mapping/depth_camera.h>

#include "run/run_observer.h"
#include "view/scene_encoder.h"

namespace highwall::apps {

// Collects what the page shows, on the thread that tracks: little for each frame and keyframe, and
// the rest when a batch is taken. Not thread-safe.
class RunFollower {
 public:
  static constexpr std::size_t kCloudPoints = 1500;  // of a keyframe at most

  // min_depth, max_depth: [m] of the points that are shown.
  RunFollower(const PinholeCamera& camera, double min_depth, double max_depth)
      : unprojector_(camera),
        min_depth_(static_cast<float>(min_depth)),
        max_depth_(static_cast<float>(max_depth)) {}

  void AddFrame(const FrameResult& result, const SlamSystem& slam);
  void AddKeyframes(const KeyframeEvent& event);
  // Returns what has happened since the last call, with the keyframes that have moved and a picture
  // of this frame. Its images are shared.
  ViewBatch Take(const FrameResult& result, const RgbdImage& image, const SlamSystem& slam,
                 const RunPosition& position);

 private:
  // Returns the keyframe that a frame in this world is relative to.
  KeyFrameId AnchorIn(SubmapId world, const Map& map);
  void CollectKeyframes(const Map& map);

  const DepthUnprojector unprojector_;
  const float min_depth_, max_depth_;
  std::optional<Stamp> begin_;
  std::vector<KeyFrameId> ids_;  // of all keyframes, also culled ones
  KeyFrameId anchor_ = kNoId;    // the newest keyframe
  std::map<KeyFrameId, KeyframeRecord> published_;
  MapNumbers numbers_;
  ViewBatch batch_;
};

}  // namespace highwall::apps
