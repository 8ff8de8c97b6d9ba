#include "generated_sequence.h"

#include <map>
#include <utility>

#include <fmt/core.h>

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

// Creates the folder atomically.
void Render(const simulate::Simulation& simulation, const std::filesystem::path& folder,
            const std::function<void(int, int)>& progress) {
  if (std::filesystem::exists(folder)) return;
  try {
    simulate::WriteTum(simulation, folder, progress);
  } catch (const IoError&) {
    if (!std::filesystem::exists(folder)) throw;  // otherwise another process was faster
  }
}

std::string Suffix(const SequenceOptions& options) {
  std::string suffix = fmt::format("_{}s_{}fps", options.duration, options.fps);
  if (options.scale != 1.0) suffix += fmt::format("_scale{}", options.scale);
  if (options.noise_ratio != simulate::kUsualNoiseRatio) {
    suffix += fmt::format("_noise{}", options.noise_ratio);
  }
  return suffix + (options.hard ? "_hard" : "");
}

}  // namespace

std::string NameOf(const SequenceOptions& options) {
  return options.scene + Suffix(options);
}

std::filesystem::path FolderOf(const SequenceOptions& options, const std::filesystem::path& cache) {
  return cache / fmt::format("{}_seed{}{}", options.scene, options.seed, Suffix(options));
}

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
  simulation.camera = simulate::Scaled(simulation.camera, options.scale);
  simulation.sensor.noise_ratio = simulation.imu.noise_ratio = options.noise_ratio;
  if (options.hard) simulation.imu.faults = simulate::HardImuFaults();
  Sequence sequence;
  sequence.simulation = std::make_unique<simulate::Simulation>(Simulate(options.scene, simulation));
  sequence.folder = FolderOf(options, cache);
  Render(*sequence.simulation, sequence.folder, progress);
  for (const simulate::Stretch& stretch : sequence.simulation->stretches()) {
    sequence.spans.push_back({std::string(ToString(stretch.kind)), stretch.begin, stretch.end});
  }
  return sequence;
}

}  // namespace highwall::bench
