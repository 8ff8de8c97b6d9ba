#include "sensor/sensor_model.h"

#include <cstddef>
#include <vector>

namespace highwall {
namespace {

// Keyframes of a map whose first ones may come from before the noise was known.
constexpr std::size_t kYoung = 10;

}  // namespace

SensorModel::SensorModel(const MeasurementModel& model, const SensorModelOptions& options,
                         const FrameTiming& timing)
    : options_(options),
      grid_(model.camera()),
      keyframe_times_(model.camera(), grid_),
      timing_(timing, model, grid_, keyframe_times_),
      noise_(model) {
  // The paper's single sigma of all rows is a choice, not knowledge.
  options_.estimates_noise &= model.options().weighting == Weighting::kCovariance;
}

std::shared_ptr<const FrameFeatures> SensorModel::WithNoise(
    const std::shared_ptr<const FrameFeatures>& features) const {
  return options_.estimates_noise ? noise_.Apply(*features) : features;
}

void SensorModel::LearnNoise(std::span<const KeyFrameId> keyframes, KeyFrameId given, Map* map) {
  if (!options_.estimates_noise) return;
  noise_.Add(*map, keyframes);
  if (map->num_keyframes() > kYoung) return;
  for (const KeyFrameId id : map->keyframe_ids()) {
    if (id <= given) continue;
    Frame& frame = map->keyframe(id)->frame;
    frame.features = noise_.Apply(*frame.features);
  }
}

std::optional<FrameTiming> SensorModel::TimingOf(const Frame& frame) const {
  if (!options_.has_row_times) return std::nullopt;
  FrameTiming times = timing();
  times.depth_delay += frame.depth_delay;
  const bool differ =
      times.colour_readout != 0.0 || times.depth_readout != 0.0 || times.depth_delay != 0.0;
  return differ ? std::optional(times) : std::nullopt;
}

void SensorModel::LearnTiming(const FrameTimingEstimator::View& view, const Map& map,
                              const FrameMotion& motion) {
  if (!options_.has_row_times) return;
  if (motion.keyframe != kNoId) keyframe_times_.Correct(motion.keyframe, motion.at_keyframe);
  if (options_.estimates_timing) timing_.Add(view, map, motion.at_frame);
}

void SensorModel::Remember(const KeyFrame& keyframe, const RowMotion& moved_by) {
  if (options_.has_row_times) keyframe_times_.Remember(keyframe, moved_by);
}

void SensorModel::CorrectMotion(KeyFrameId keyframe, const Twist& by_readings) {
  keyframe_times_.CorrectByReadings(keyframe, by_readings);
}

void SensorModel::Compensate(std::span<const KeyFrameId> keyframes, Map* map) {
  if (!options_.has_row_times) return;
  FrameTimingEstimate by{.value = timing()};
  if (options_.estimates_timing) by.sigma = timing_.estimate().sigma;
  keyframe_times_.Compensate(by, keyframes, map);
}

void SensorModel::CompensateAround(const PerKind<LandmarkIds>& landmarks, int most, Map* map) {
  std::vector<KeyFrameId> around;
  for (const auto& [id, shared] : map->Observers(landmarks)) {
    if (static_cast<int>(around.size()) == most) break;
    around.push_back(id);
  }
  Compensate(around, map);
}

void SensorModel::CompensateAll(Map* map) {
  for (const SubmapId root : map->roots()) Compensate(map->KeyFramesOf(root), map);
}

}  // namespace highwall
