#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <highwall/core/camera.h>

#include "view/frame_event.h"
#include "view/scene_text.h"
#include "view/view_hub.h"

namespace highwall::apps {

// What has happened in a run since the batch before.
struct ViewBatch {
  std::optional<FramePicture> picture;
  std::vector<FrameRecord> frames;
  std::vector<KeyframeRecord> keyframes;  // new and moved ones
  std::vector<KeyframeCloudSample> clouds;
  std::vector<LoopRecord> loops;
};

// Writes batches as events and blocks. Not thread-safe.
class SceneEncoder {
 public:
  // hub: must outlive this object.
  SceneEncoder(ViewHub& hub, const PinholeCamera& camera) : hub_(hub), camera_(camera) {}

  void Encode(const ViewBatch& batch);

 private:
  void EncodeFrames(const std::vector<FrameRecord>& frames);
  void EncodeKeyframes(const std::vector<KeyframeRecord>& keyframes);

  ViewHub& hub_;
  const PinholeCamera camera_;
  std::vector<FrameRecord> frames_;  // of the last block
  std::size_t first_ = 0;            // index of the first of them in the run
  std::map<std::int32_t, KeyframeRecord> keyframes_;
  std::vector<LoopRecord> loops_;
};

}  // namespace highwall::apps
