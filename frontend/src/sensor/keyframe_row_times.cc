#include "sensor/keyframe_row_times.h"

#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace highwall {
namespace {

// Shifts of landmarks that follow from shifts of the features in their keyframes: the mean over the
// keyframes that measured their depth.
class LandmarkShifts {
 public:
  explicit LandmarkShifts(const PinholeCamera& camera) : camera_(camera) {}

  // Adds a keyframe whose features were `before` and have been replaced.
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
      // A landmark is longer than its segment in one image: both of its ends get the same shift.
      lines_.try_emplace(keyframe.lines[i], Eigen::Vector3d::Zero()).first->second +=
          0.5 * R_WC * (to->p_C - from->p_C + to->q_C - from->q_C);
    }
  }

  void Apply(Map* map) const {
    for (const auto& [id, sum] : points_) {
      MapPoint* point = map->Find(id);
      if (point == nullptr) continue;
      point->p_W += sum / Measured(*map, point->observations, [](const auto& features, auto i) {
                      return features.points[i].depth > 0.0;
                    });
    }
    for (const auto& [id, sum] : lines_) {
      MapLine* line = map->Find(id);
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

bool IsBeyondSigma(const FrameTimingEstimate& estimate, const FrameTiming& from) {
  const auto is_beyond = [&](double FrameTiming::*part) {
    return std::abs(estimate.value.*part - from.*part) > estimate.sigma.*part;
  };
  return is_beyond(&FrameTiming::colour_readout) || is_beyond(&FrameTiming::depth_readout) ||
         is_beyond(&FrameTiming::depth_delay);
}

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

void KeyframeRowTimes::Compensate(const FrameTimingEstimate& timing,
                                  std::span<const KeyFrameId> keyframes, Map* map) {
  LandmarkShifts shifts(camera_);
  for (const KeyFrameId id : keyframes) {
    const auto found = keyframes_.find(id);
    KeyFrame* keyframe = map->keyframe(id);
    if (found == keyframes_.end() || keyframe == nullptr) continue;
    Known& known = found->second;
    RowMotion now{timing.value, known.motion};
    now.timing.depth_delay += keyframe->frame.depth_delay;
    if (!IsBeyondSigma({now.timing, timing.sigma}, known.moved_by.timing))
      now.timing = known.moved_by.timing;
    if (!Differ(known.moved_by, now, camera_, known.depth)) continue;
    const auto before = std::exchange(
        keyframe->frame.features,
        MovedOtherwise(*keyframe->frame.features, camera_, grid_, known.moved_by, now));
    shifts.Add(*keyframe, *before);
    known.moved_by = now;
  }
  shifts.Apply(map);
  Forget(*map);
}

void KeyframeRowTimes::Forget(const Map& map) {
  if (keyframes_.size() <= 2 * map.num_keyframes()) return;
  std::erase_if(keyframes_,
                [&](const auto& known) { return map.keyframe(known.first) == nullptr; });
}

}  // namespace highwall
