#include "view/run_follower.h"

#include <utility>

#include <highwall/frontend/map/map.h>

namespace highwall::apps {
namespace {

// A keyframe that has moved less is shown where it was.
constexpr double kMoved = 2e-3;    // [m]
constexpr double kRotated = 1e-3;  // [rad]

bool HasMoved(const Pose& before, const Pose& now) {
  return (now.p() - before.p()).norm() > kMoved || now.q().angularDistance(before.q()) > kRotated;
}

KeyframeRecord RecordOf(KeyFrameId id, const Map& map) {
  KeyframeRecord record{.id = id.value()};
  const std::optional<SubmapId> root = map.RootOf(id);
  if (!root) return record;
  record.world = root->value();
  record.active = map.keyframe(id) != nullptr;
  record.T_WC = map.ResolvePose(id);
  return record;
}

}  // namespace

KeyFrameId RunFollower::AnchorIn(SubmapId world, const Map& map) {
  if (anchor_ == kNoId || map.RootOf(anchor_) != world) {
    const std::vector<KeyFrameId> keyframes = map.KeyFramesOf(world);
    anchor_ = keyframes.empty() ? KeyFrameId(kNoId) : keyframes.back();
  }
  return anchor_;
}

void RunFollower::AddFrame(const FrameResult& result, const SlamSystem& slam) {
  const Map& map = slam.map();
  if (!begin_) {
    begin_ = result.stamp;
    ids_ = map.keyframe_ids();  // of a given map, or the first one
  }
  if (result.mapping && (ids_.empty() || ids_.back() < result.mapping->keyframe)) {
    ids_.push_back(result.mapping->keyframe);
  }
  if (result.mapping) anchor_ = result.mapping->keyframe;
  for (const LoopReport& report : result.loops) {
    if (report.bundle) continue;  // of a loop already counted
    ++(report.accepted ? numbers_.loops : numbers_.refused);
    const bool merged = report.accepted && report.merge;
    if (merged) ++numbers_.merges;
    const LoopEdge& edge = report.loop.edge;
    batch_.loops.push_back({edge.match.value(), edge.keyframe.value(), report.accepted, merged});
  }
  FrameRecord record{.seconds = ToSeconds(result.stamp - *begin_),
                     .state = result.state,
                     .points = result.matched_points,
                     .lines = result.matched_lines,
                     .features = static_cast<float>(result.times.features),
                     .pose = static_cast<float>(result.times.tracking),
                     .mapping = static_cast<float>(result.times.mapping),
                     .total = static_cast<float>(result.times.total)};
  if (result.inertial) record.weight = static_cast<float>(result.inertial->weight);
  if (HasPose(result.state)) {
    if (const KeyFrameId anchor = AnchorIn(result.submap, map); anchor != kNoId) {
      record.anchor = anchor.value();
      record.p_K = (map.ResolvePose(anchor).Inverse() * result.T_WC.p()).cast<float>();
    }
  }
  batch_.frames.push_back(record);
}

void RunFollower::AddKeyframes(const KeyframeEvent& event) {
  for (const KeyframeView& view : event.added) {
    batch_.clouds.push_back(
        SampleKeyframe(view, unprojector_, min_depth_, max_depth_, kCloudPoints));
  }
}

void RunFollower::CollectKeyframes(const Map& map) {
  for (const KeyFrameId id : ids_) {
    const KeyframeRecord now = RecordOf(id, map);
    const auto [at, is_new] = published_.try_emplace(id, now);
    const KeyframeRecord& before = at->second;
    if (!is_new && before.world == now.world && before.active == now.active &&
        !HasMoved(before.T_WC, now.T_WC)) {
      continue;
    }
    at->second = now;
    batch_.keyframes.push_back(now);
  }
}

ViewBatch RunFollower::Take(const FrameResult& result, const RgbdImage& image,
                            const SlamSystem& slam, const RunPosition& position) {
  const Map& map = slam.map();
  CollectKeyframes(map);
  numbers_.keyframes = map.num_keyframes();
  numbers_.points = map.num<MapPoint>();
  numbers_.lines = map.num<MapLine>();
  numbers_.submaps = map.roots().size();
  batch_.picture = FramePicture{result, image.bgr, position, numbers_,
                                ToSeconds(result.stamp - begin_.value_or(result.stamp))};
  return std::exchange(batch_, {});
}

}  // namespace highwall::apps
