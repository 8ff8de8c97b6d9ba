#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/trajectory.h>

#include "paired_setting.h"
#include "paired_statistics.h"

// Two settings against each other, from the same beginnings of the same sequences.
namespace highwall::bench {

struct PairedArguments {
  std::string data;                    // the folder that holds the sequences
  std::vector<std::string> sequences;  // folders in it
  std::pair<std::string, std::string> settings;
  std::string program;   // `highwall` of another build, which runs the second; empty: this one
  int pairs = 5;         // of each sequence, >= 1
  std::size_t step = 5;  // [frames] from one beginning to the next
  bool json = false;
};

// A run of each setting from one beginning.
struct Pair {
  std::size_t begin = 0;  // [frames]
  SettingRun a, b;
  std::size_t common_frames = 0;    // with a pose in both
  double ape_a = 0.0, ape_b = 0.0;  // RMSE over them [m], each aligned by itself
  std::string problem;              // why they are not compared; empty: they are
};

// Compares two runs over `frames` frames. They are not compared where one has no pose of half of
// the frames in one map, or too few poses in common for an error.
Pair ComparePair(const Trajectory& truth, std::size_t begin, std::size_t frames, SettingRun a,
                 SettingRun b);

// ln(b / a) of the errors of the pairs that are compared; empty for none.
std::optional<MeanLog> MeanLogRatio(const std::vector<Pair>& pairs);

// Runs and prints. The settings are those that RequireSetting() takes, the second one what
// `program` takes. Throws IoError for a sequence without ground truth or too short, and what the
// runs throw.
void RunPaired(const PairedArguments& arguments);

}  // namespace highwall::bench
