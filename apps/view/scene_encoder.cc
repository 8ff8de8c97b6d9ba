#include "view/scene_encoder.h"

#include <set>
#include <string>

namespace highwall::apps {
namespace {

constexpr std::size_t kFramesOfBlock = 64;
constexpr std::int32_t kKeyframesOfBlock = 32;

}  // namespace

void SceneEncoder::EncodeFrames(const std::vector<FrameRecord>& frames) {
  const auto publish = [&] {
    hub_.SetBlock("frames/" + std::to_string(first_), FramesBlock(first_, frames_));
  };
  for (const FrameRecord& frame : frames) {
    frames_.push_back(frame);
    if (frames_.size() < kFramesOfBlock) continue;
    publish();
    first_ += frames_.size();
    frames_.clear();
  }
  if (!frames.empty() && !frames_.empty()) publish();
}

void SceneEncoder::EncodeKeyframes(const std::vector<KeyframeRecord>& keyframes) {
  std::set<std::int32_t> changed;
  for (const KeyframeRecord& keyframe : keyframes) {
    keyframes_[keyframe.id] = keyframe;
    changed.insert(keyframe.id / kKeyframesOfBlock);
  }
  for (const std::int32_t block : changed) {
    std::vector<KeyframeRecord> content;
    const auto end = keyframes_.lower_bound((block + 1) * kKeyframesOfBlock);
    for (auto at = keyframes_.lower_bound(block * kKeyframesOfBlock); at != end; ++at) {
      content.push_back(at->second);
    }
    hub_.SetBlock("keyframes/" + std::to_string(block), KeyframesBlock(content));
  }
}

void SceneEncoder::Encode(const ViewBatch& batch) {
  EncodeKeyframes(batch.keyframes);
  EncodeFrames(batch.frames);
  for (const KeyframeCloudSample& cloud : batch.clouds) {
    hub_.SetBlock("cloud/" + std::to_string(cloud.id), CloudBlock(cloud));
  }
  loops_.insert(loops_.end(), batch.loops.begin(), batch.loops.end());
  if (!batch.loops.empty()) hub_.SetBlock("loops", LoopsBlock(loops_));
  if (batch.picture) hub_.Post("frame", FrameEvent(*batch.picture, camera_));
}

}  // namespace highwall::apps
