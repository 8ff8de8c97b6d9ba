#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>

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

// Renders the sequence into a folder of `cache`, unless an earlier run has done so. The folder's
// name tells the options, not the version of the simulator. progress(done, total). Throws IoError.
Sequence MakeSequence(const SequenceOptions& options, const std::filesystem::path& cache,
                      const std::function<void(int, int)>& progress);

// A dataset whose lens is covered for a while: black images without depth.
class CoveredLens final : public Dataset {
 public:
  // dataset: must outlive this. [begin, end]: stamps.
  CoveredLens(const Dataset& dataset, Stamp begin, Stamp end)
      : dataset_(dataset), begin_(begin), end_(end) {}

  std::size_t size() const override { return dataset_.size(); }
  Stamp stamp(std::size_t index) const override { return dataset_.stamp(index); }
  const Trajectory* groundtruth() const override { return dataset_.groundtruth(); }
  std::optional<std::filesystem::path> imu_file() const override { return dataset_.imu_file(); }

 private:
  RgbdImage DoLoad(std::size_t index) const override;

  const Dataset& dataset_;
  Stamp begin_, end_;
};

}  // namespace highwall::bench
