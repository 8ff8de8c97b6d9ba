#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/trajectory.h>

#include "paired_setting.h"
#include "paired_statistics.h"

// Paired comparison of two settings, from the same start frames of the same sequences.
namespace highwall::bench {

struct PairedArguments {
  std::string data;                    // folder of the sequences
  std::vector<std::string> sequences;  // folders in it
  std::pair<std::string, std::string> settings;
  std::string program;   // `highwall` of another build, which runs the second; empty: this one
  int pairs = 5;         // of each sequence, >= 1
  std::size_t step = 5;  // [frames] between the start frames
  bool json = false;
};

// A run of each setting from one start frame.
struct Pair {
  std::size_t begin = 0;  // [frames]
  SettingRun a, b;
  std::size_t common_frames = 0;    // with a pose in both
  double ape_a = 0.0, ape_b = 0.0;  // RMSE over them [m], each aligned separately
  std::string problem;              // why they are not compared; empty: they are
};

// Compares two runs over `frames` frames. There is no comparison if one of them has no pose for
// half of the frames in one map, or if there are too few common poses for an error.
Pair ComparePair(const Trajectory& truth, std::size_t begin, std::size_t frames, SettingRun a,
                 SettingRun b);

// Returns ln(b / a) of the errors of the compared pairs; empty for none.
std::optional<MeanLog> MeanLogRatio(const std::vector<Pair>& pairs);

// Runs and prints. Settings are accepted by RequireSetting(), the second one by `program`. Throws
// IoError for a sequence without ground truth or one that is too short, and the errors of the runs.
void RunPaired(const PairedArguments& arguments);

}  // namespace highwall::bench
