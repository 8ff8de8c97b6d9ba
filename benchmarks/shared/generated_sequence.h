#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "simulate/camera/simulation.h"
#include "simulate/noise_ratio.h"

namespace highwall::bench {

// Part of a sequence that is scored separately.
struct MarkedSpan {
  std::string name;
  double begin = 0.0, end = 0.0;  // [s] since the first frame
};

struct SequenceOptions {
  std::string scene = "room";
  std::uint64_t seed = 1;
  double duration = 20.0;                           // [s] > 0; DefaultDuration()
  double fps = 30.0;                                // [Hz] > 0
  double scale = 1.0;                               // > 0; of the image size
  double noise_ratio = simulate::kUsualNoiseRatio;  // > 0; true noise relative to the data sheets
  bool hard = false;                                // the IMU has simulate::HardImuFaults()
};

// Returns the names that MakeSequence() supports.
std::vector<std::string> SceneNames();
// Returns the lap time [s] of the mine or the road, or one through the room.
double DefaultDuration(const std::string& scene);

// Generated sequence: the images on disk, the ground truth in memory, and the difficult parts.
struct Sequence {
  std::unique_ptr<simulate::Simulation> simulation;
  std::filesystem::path folder;
  std::vector<MarkedSpan> spans;
};

// Returns the name of the sequence without its seed: "room_20s_30fps".
std::string NameOf(const SequenceOptions& options);
// Returns its folder in `cache`; its name encodes the options, not the version of the simulator.
std::filesystem::path FolderOf(const SequenceOptions& options, const std::filesystem::path& cache);
// Renders the sequence into this folder, unless an earlier run or a concurrent process has done so.
// progress(done, total). Throws IoError.
Sequence MakeSequence(const SequenceOptions& options, const std::filesystem::path& cache,
                      const std::function<void(int, int)>& progress);

}  // namespace highwall::bench
