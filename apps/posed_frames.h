#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>

#include "opened_dataset.h"

namespace highwall::apps {

// What `highwall map` and `highwall map compare --seen-by` are given: a dataset, or the folder of a
// run (with run.json), which names its dataset.
struct MapSource {
  std::filesystem::path dataset;
  std::filesystem::path run;         // whose depth is to be corrected alike; empty: of no run
  std::filesystem::path trajectory;  // file of T_WC
  std::string config;                // that the run was made with, as OpenDataset() takes it
  double max_pair_difference = kMaxPairDifference;  // [s] likewise
  bool keyframes = false;                           // the trajectory holds keyframes alone
  bool level = true;  // z of W points up; of a run it need not: W is its first camera
};

// trajectory, dataset: override what the source says where they are not empty. The trajectory of a
// run is its keyframes.txt, that of a dataset its groundtruth.txt. Throws IoError where the source
// is neither, where a run names a dataset that is not there, and where it has no keyframes because
// it localized only.
MapSource ResolveSource(const std::filesystem::path& source, const std::string& dataset,
                        const std::string& trajectory);

struct PosedFrame {
  std::size_t index = 0;  // in the dataset
  Pose T_WC;
};

// Every `every`-th of the frames that the trajectory has a pose for, within 20 ms; interpolated
// where it lies between two.
std::vector<PosedFrame> PosedFrames(const Dataset& dataset, const Trajectory& trajectory,
                                    std::size_t every);

}  // namespace highwall::apps
