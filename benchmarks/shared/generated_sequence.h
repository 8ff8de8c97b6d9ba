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

// A part of a sequence that is scored by itself.
struct MarkedSpan {
  std::string name;
  double begin = 0.0, end = 0.0;  // [s] since the first frame
};

struct SequenceOptions {
  std::string scene = "room";
  std::uint64_t seed = 1;
  double duration = 20.0;                           // [s] > 0; DefaultDuration()
  double fps = 30.0;                                // [Hz] > 0
  double scale = 1.0;                               // > 0; of the images' sides
  double noise_ratio = simulate::kUsualNoiseRatio;  // > 0; true noise over the data sheets'
  bool hard = false;                                // the IMU has simulate::HardImuFaults()
};

// The names that MakeSequence() knows.
std::vector<std::string> SceneNames();
// [s] of a lap of the mine or the road, and of one through the room.
double DefaultDuration(const std::string& scene);

// A generated sequence: the images on disk, the truth in memory, the hard parts marked.
struct Sequence {
  std::unique_ptr<simulate::Simulation> simulation;
  std::filesystem::path folder;
  std::vector<MarkedSpan> spans;
};

// What the sequence is called, whatever its seed: "room_20s_30fps".
std::string NameOf(const SequenceOptions& options);
// The folder of `cache` that is its place; its name tells the options, not the version of the
// simulator.
std::filesystem::path FolderOf(const SequenceOptions& options, const std::filesystem::path& cache);
// Renders the sequence into this folder, unless an earlier run has done so, or another process that
// does so at the same time. progress(done, total). Throws IoError.
Sequence MakeSequence(const SequenceOptions& options, const std::filesystem::path& cache,
                      const std::function<void(int, int)>& progress);

}  // namespace highwall::bench
