#include "sequence.h"

#include <map>
#include <utility>

#include <fmt/core.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

#include "scenes.h"
#include "simulate/output/tum_writer.h"

namespace highwall::bench {
namespace {

struct Scene {
  simulate::SimulationOptions options;
  double duration;  // [s]
};

const std::map<std::string, Scene>& Scenes() {
  static const std::map<std::string, Scene> scenes{{"mine", {simulate::FieldTestOptions(), 90.0}},
                                                   {"road", {simulate::FieldTestOptions(), 70.0}},
                                                   {"room", {{}, 20.0}}};
  return scenes;
}

}  // namespace

std::vector<std::string> SceneNames() {
  std::vector<std::string> names;
  for (const auto& [name, make] : Scenes()) names.push_back(name);
  return names;
}

double DefaultDuration(const std::string& scene) {
  return Scenes().at(scene).duration;
}

Sequence MakeSequence(const SequenceOptions& options, const std::filesystem::path& cache,
                      const std::function<void(int, int)>& progress) {
  const Scene& scene = Scenes().at(options.scene);
  simulate::SimulationOptions simulation = scene.options;
  simulation.seed = options.seed;
  simulation.duration = options.duration;
  simulation.fps = options.fps;
  simulation.sensor.noise_ratio = simulation.imu.noise_ratio = options.noise_ratio;
  if (options.hard) simulation.imu.faults = simulate::HardImuFaults();
  Sequence sequence;
  sequence.simulation = std::make_unique<simulate::Simulation>(Simulate(options.scene, simulation));
  std::string name = fmt::format("{}_seed{}_{}s_{}fps", options.scene, options.seed,
                                 options.duration, options.fps);
  if (options.noise_ratio != simulate::kUsualNoiseRatio) {
    name += fmt::format("_noise{}", options.noise_ratio);
  }
  if (options.hard) name += "_hard";
  sequence.folder = cache / name;
  if (!std::filesystem::exists(sequence.folder)) {  // it appears whole or not at all
    simulate::WriteTum(*sequence.simulation, sequence.folder, progress);
  }
  for (const simulate::Stretch& stretch : sequence.simulation->stretches()) {
    sequence.spans.push_back({std::string(ToString(stretch.kind)), stretch.begin, stretch.end});
  }
  return sequence;
}

RgbdImage CoveredLens::DoLoad(std::size_t index) const {
  std::optional<RgbdImage> image = dataset_.Load(index);
  if (!image) throw IoError(fmt::format("frame {}", index), "cannot be used");
  if (image->stamp >= begin_ && image->stamp <= end_) {
    image->bgr.setTo(0);
    image->depth.setTo(0);
  }
  return *std::move(image);
}

}  // namespace highwall::bench
