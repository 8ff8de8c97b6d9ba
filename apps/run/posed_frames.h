#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>

#include "run/opened_dataset.h"

namespace highwall::apps {

// Input of `highwall map` and `highwall map compare --seen-by`: a dataset, or the folder of a run
// (with run.json), which names its dataset.
struct MapSource {
  std::filesystem::path dataset;
  std::filesystem::path run;         // its depth corrections are applied; empty: not a run
  std::filesystem::path trajectory;  // file of T_WC
  std::string config;                // configuration of the run, as OpenWithConfig() takes it
  DatasetOptions images{};           // likewise
  bool keyframes = false;            // the trajectory has keyframes only
  bool level = true;  // z of W points up; not for every run: W is its first camera frame
};

// trajectory, dataset: override those of the source if not empty. The trajectory of a run is its
// keyframes.txt, that of a dataset its groundtruth.txt. Throws IoError if the source is neither, if
// a run names a dataset that does not exist, or if the run has no keyframes because it was
// localization-only.
MapSource ResolveSource(const std::filesystem::path& source, const std::string& dataset,
                        const std::string& trajectory);

struct PosedFrame {
  std::size_t index = 0;  // in the dataset
  Pose T_WC;
};

// Returns every `every`-th frame for which the trajectory has a pose within 20 ms, interpolated
// between neighbouring poses.
std::vector<PosedFrame> PosedFrames(const Dataset& dataset, const Trajectory& trajectory,
                                    std::size_t every);

}  // namespace highwall::apps
