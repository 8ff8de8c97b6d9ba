#include "tracking/keyframe_row_times.h"

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace highwall {
namespace {

// By how much landmarks move when features of their keyframes do: the mean over the keyframes that
// measured their depth.
class LandmarkShifts {
 public:
  explicit LandmarkShifts(const PinholeCamera& camera) : camera_(camera) {}

  // The features of a keyframe were `before`, and are what it holds now.
  void Add(const KeyFrame& keyframe, const FrameFeatures& before) {
    const FrameFeatures& after = *keyframe.frame.features;
    const Eigen::Matrix3d R_WC = keyframe.T_WC.q().toRotationMatrix();
    for (std::size_t i = 0; i < before.points.size(); ++i) {
      const PointFeature &from = before.points[i], &to = after.points[i];
      if (keyframe.points[i] == kNoId || !(from.depth > 0.0)) continue;
      points_.try_emplace(keyframe.points[i], Eigen::Vector3d::Zero()).first->second +=
          R_WC * (camera_.Unproject(to.uv, to.depth) - camera_.Unproject(from.uv, from.depth));
    }
    for (std::size_t i = 0; i < before.lines.size(); ++i) {
      const auto &from = before.lines[i].segment_C, &to = after.lines[i].segment_C;
      if (keyframe.lines[i] == kNoId || !from || !to) continue;
      // A landmark is longer than what one image shows of it: both of its ends move alike.
      lines_.try_emplace(keyframe.lines[i], Eigen::Vector3d::Zero()).first->second +=
          0.5 * R_WC * (to->p_C - from->p_C + to->q_C - from->q_C);
    }
  }

  void Apply(Map* map) const {
    for (const auto& [id, sum] : points_) {
      MapPoint* point = map->point(id);
      if (point == nullptr) continue;
      point->p_W += sum / Measured(*map, point->observations, [](const auto& features, auto i) {
                      return features.points[i].depth > 0.0;
                    });
    }
    for (const auto& [id, sum] : lines_) {
      MapLine* line = map->line(id);
      if (line == nullptr) continue;
      const Eigen::Vector3d shift =
          sum / Measured(*map, line->observations, [](const auto& features, auto i) {
            return features.lines[i].segment_C.has_value();
          });
      line->segment_W = Segment3(line->segment_W.p() + shift, line->segment_W.q() + shift);
    }
  }

 private:
  template <class HasDepth>
  static double Measured(const Map& map, const std::vector<Observation>& observations,
                         const HasDepth& has_depth) {
    int count = 0;
    for (const Observation& observation : observations) {
      const KeyFrame* keyframe = map.keyframe(observation.keyframe);
      if (keyframe == nullptr) continue;
      count += has_depth(*keyframe->frame.features, static_cast<std::size_t>(observation.index));
    }
    return count;
  }

  const PinholeCamera& camera_;
  std::map<PointId, Eigen::Vector3d> points_;  // [m] sums
  std::map<LineId, Eigen::Vector3d> lines_;
};

}  // namespace

void KeyframeRowTimes::Remember(const KeyFrame& keyframe, const RowMotion& moved_by) {
  keyframes_[keyframe.id] = {moved_by, moved_by.motion, MedianDepth(*keyframe.frame.features)};
}

void KeyframeRowTimes::Correct(KeyFrameId id, const Twist& motion) {
  if (const auto known = keyframes_.find(id); known != keyframes_.end()) {
    known->second.motion = motion;
  }
}

const RowMotion* KeyframeRowTimes::Find(KeyFrameId id) const {
  const auto known = keyframes_.find(id);
  return known != keyframes_.end() ? &known->second.moved_by : nullptr;
}

void KeyframeRowTimes::Retime(const FrameTiming& timing, Map* map) {
  LandmarkShifts shifts(camera_);
  for (auto it = keyframes_.begin(); it != keyframes_.end();) {
    KeyFrame* keyframe = map->keyframe(it->first);
    if (keyframe == nullptr) {
      it = keyframes_.erase(it);
      continue;
    }
    Known& known = it++->second;
    RowMotion now{timing, known.motion};
    now.timing.depth_delay += keyframe->frame.depth_delay;
    if (!Differ(known.moved_by, now, camera_, known.depth)) continue;
    const auto before = std::exchange(
        keyframe->frame.features,
        MovedOtherwise(*keyframe->frame.features, camera_, grid_, known.moved_by, now));
    shifts.Add(*keyframe, *before);
    known.moved_by = now;
  }
  shifts.Apply(map);
}

}  // namespace highwall
