#include "sensor/keyframe_row_times.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "features/feature_kinds.h"

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
    ForEachKind([&]<class Landmark>() {
      const LandmarkIds<Landmark>& landmarks = PartOf<Landmark>(keyframe);
      for (std::size_t i = 0; i < landmarks.size(); ++i) {
        if (landmarks[i] == kNoId) continue;
        const auto shift =
            ShiftOf(PartOf<Landmark>(before)[i], PartOf<Landmark>(after)[i], camera_);
        if (!shift) continue;
        PartOf<Landmark>(shifts_).emplace_back(landmarks[i], R_WC * *shift);
      }
    });
  }

  void Apply(Map* map) {
    ForEachKind([&]<class Landmark>() {
      Shifts<Landmark>& shifts = PartOf<Landmark>(shifts_);
      const auto id_of = [](const auto& shift) { return shift.first; };
      std::ranges::stable_sort(shifts, {}, id_of);
      for (auto begin = shifts.begin(); begin != shifts.end();) {
        const Id<Landmark> id = begin->first;
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (; begin != shifts.end() && begin->first == id; ++begin) sum += begin->second;
        Landmark* const landmark = map->Find(id);
        if (landmark == nullptr) continue;
        LandmarkTraits<Landmark>::Shift(sum / Measured(*map, *landmark), *landmark);
      }
    });
  }

 private:
  template <class Landmark>
  using Shifts = std::vector<std::pair<Id<Landmark>, Eigen::Vector3d>>;  // [m] in W

  // Returns the number of keyframes that measured the depth of the landmark.
  template <class Landmark>
  static double Measured(const Map& map, const Landmark& landmark) {
    int count = 0;
    for (const Observation& observation : landmark.observations) {
      const KeyFrame* keyframe = map.keyframe(observation.keyframe);
      if (keyframe == nullptr) continue;
      const auto& features = PartOf<Landmark>(*keyframe->frame.features);
      count += HasDepth(features[static_cast<std::size_t>(observation.index)]) ? 1 : 0;
    }
    return count;
  }

  const PinholeCamera& camera_;
  PerKind<Shifts> shifts_;
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

void KeyframeRowTimes::CorrectByReadings(KeyFrameId id, const Twist& motion) {
  if (const auto known = keyframes_.find(id); known != keyframes_.end()) {
    known->second.by_readings = motion;
  }
}

void KeyframeRowTimes::ForgetReadings() {
  for (auto& [id, known] : keyframes_) known.by_readings.reset();
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
    RowMotion now{timing.value, known.by_readings.value_or(known.motion)};
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
