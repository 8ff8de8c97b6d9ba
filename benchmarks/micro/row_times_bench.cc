#include <cstddef>
#include <span>
#include <vector>

#include <benchmark/benchmark.h>

#include "sensor/keyframe_row_times.h"
#include "support/synthetic_scene.h"

namespace highwall::row_times_bench {
namespace {

constexpr int kOfAPlace = 12;  // keyframes, as many as a local adjustment optimizes

// Map of places whose keyframes observe the same landmarks.
class Places {
 public:
  explicit Places(int keyframes) {
    const testing::Scene scene = testing::MakeScene(4, 1000, 80);
    const testing::SyntheticView view = testing::Look(scene, sensor_, Pose());
    while (static_cast<int>(ids_.size()) < keyframes) AddPlace(view);
  }

  // Alternates between two timings whose difference exceeds both sigmas.
  void Compensate(std::span<const KeyFrameId> keyframes) {
    moved_ = !moved_;
    const double readout = moved_ ? 0.03 : 0.01;
    times_.Compensate({.value = {.colour_readout = readout, .depth_readout = readout}}, keyframes,
                      &map_);
  }
  std::span<const KeyFrameId> all() const { return ids_; }

 private:
  void AddPlace(const testing::SyntheticView& view) {
    const FrameFeatures& features = *view.features;
    std::vector<PointId> points;
    for (const PointFeature& point : features.points) {
      points.push_back(map_.Add<MapPoint>(sensor_.camera.Unproject(point.uv, point.depth), 0).id);
    }
    for (int k = 0; k < kOfAPlace; ++k) {
      Frame frame;
      frame.features = view.features;
      const KeyFrame& keyframe = map_.AddKeyFrame(frame, Pose());
      for (std::size_t i = 0; i < points.size(); ++i) {
        map_.Observe(keyframe.id, static_cast<int>(i), points[i]);
      }
      times_.Remember(keyframe, {{}, {.v = {0.5, -0.3, 0.2}, .omega = {0.6, 1.2, -0.4}}});
      ids_.push_back(keyframe.id);
    }
  }

  const RgbdSensor sensor_ = testing::IdealSensor();
  const DepthGrid grid_{sensor_.camera};
  Map map_;
  KeyframeRowTimes times_{sensor_.camera, grid_};
  std::vector<KeyFrameId> ids_;
  bool moved_ = false;
};

// At a new keyframe: retimes those around it. state.range(0): keyframes of the map.
void BM_CompensateAround(benchmark::State& state) {
  Places places(static_cast<int>(state.range(0)));
  for ([[maybe_unused]] const auto _ : state) places.Compensate(places.all().last(kOfAPlace));
}
BENCHMARK(BM_CompensateAround)->Arg(100)->Arg(400)->Arg(1600)->Unit(benchmark::kMillisecond);

// Retimes all keyframes, as before a loop, and as formerly at every new keyframe.
void BM_CompensateAll(benchmark::State& state) {
  Places places(static_cast<int>(state.range(0)));
  for ([[maybe_unused]] const auto _ : state) places.Compensate(places.all());
}
BENCHMARK(BM_CompensateAll)->Arg(100)->Arg(400)->Arg(1600)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace highwall::row_times_bench
