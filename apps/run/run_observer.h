#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include <highwall/core/keyframe_event.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/system/slam_system.h>
#include <highwall/mapping/octomap_builder.h>

namespace highwall::apps {

// Frames of a run so far.
struct RunPosition {
  std::size_t done = 0, total = 0;
  std::size_t dropped = 0;  // in live mode
};

// Watches a run while it tracks: RunSlam() calls it. OnFrame() and OnKeyframes() are called on the
// thread that tracks, OnOctree() on the one that builds the dense map, which may be the same.
class RunObserver {
 public:
  RunObserver() = default;
  virtual ~RunObserver() = default;
  RunObserver(const RunObserver&) = delete;
  RunObserver& operator=(const RunObserver&) = delete;

  // After each frame. The images are shared and must not be changed. The run continues when this
  // returns.
  virtual void OnFrame(const FrameResult& result, const RgbdImage& image, const SlamSystem& slam,
                       const RunPosition& position) = 0;
  // As SlamCallbacks::on_keyframes.
  virtual void OnKeyframes(const KeyframeEvent& event) = 0;
  // As DenseMapper::OctreeCallback; world: of the submap.
  virtual void OnOctree(std::int32_t world, const OctomapBuilder& octree) = 0;

  // Adds the calls of OnKeyframes() to the callbacks, after those that are set.
  void AddTo(SlamCallbacks* callbacks) {
    callbacks->on_keyframes =
        [this, before = std::move(callbacks->on_keyframes)](const KeyframeEvent& event) {
          if (before) before(event);
          OnKeyframes(event);
        };
  }
};

}  // namespace highwall::apps
