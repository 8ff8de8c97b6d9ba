#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "generated_sequence.h"
#include "sweep_record.h"

// Settings x sequences x seeds x runs, in one process or distributed over several.
namespace highwall::bench {

// The n-th of `count` parts of about equal size.
struct Shard {
  std::size_t number = 1;  // 1 to count
  std::size_t count = 1;
};
// Parses "2/4". Throws InvalidArgument.
Shard ParseShard(const std::string& text);

struct SweepPlan {
  std::filesystem::path data;           // folder of the sequences, including generated ones
  std::vector<std::string> sequences;   // folders in it that `highwall slam` accepts
  std::vector<SequenceOptions> scenes;  // generated ones, each with `seeds` seeds from 1 on
  int seeds = 1;                        // >= 1
  std::vector<NamedSetting> settings;
  int runs = 5;  // of each, >= 1
  bool synchronous = false;
  double live_rate = 0.0;     // as SettingMode::live_rate
  std::filesystem::path out;  // folder for the runs; empty: they are not kept
  Shard shard;
  std::function<bool()> stop{};  // called between frames: true ends the sweep; empty: never
};

// Called when all runs of a sequence with a setting that are in the shard are done.
using GroupCallback = std::function<void(const std::vector<RunRecord>& group)>;

// Runs everything that is not yet kept, and returns all runs, including kept ones, sequence by
// sequence. If plan.stop ends the sweep, only completed runs are returned. Throws IoError for a
// sequence that cannot be used and for a kept run with other switches, and the errors of the runs.
std::vector<RunRecord> RunSweep(const SweepPlan& plan, const GroupCallback& on_group = {});

}  // namespace highwall::bench
