#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "generated_sequence.h"
#include "sweep_record.h"

// Settings x sequences x seeds x runs, in one process or in parts of several.
namespace highwall::bench {

// The n-th of so many parts, which are about equally large.
struct Shard {
  std::size_t number = 1;  // 1 to count
  std::size_t count = 1;
};
// "2/4". Throws InvalidArgument.
Shard ParseShard(const std::string& text);

struct SweepPlan {
  std::filesystem::path data;           // holds the sequences, also those that are generated
  std::vector<std::string> sequences;   // folders in it, that `highwall slam` takes
  std::vector<SequenceOptions> scenes;  // generated ones, each with `seeds` seeds from 1 on
  int seeds = 1;                        // >= 1
  std::vector<NamedSetting> settings;
  int runs = 5;  // of each, >= 1
  bool lockstep = false;
  std::filesystem::path out;  // keeps the runs; empty: nothing is kept
  Shard shard;
  std::function<bool()> stop{};  // asked between frames: true ends the sweep; empty: never
};

// Called where all runs of a sequence with a setting, as far as they are in the shard, are done.
using GroupCallback = std::function<void(const std::vector<RunRecord>& group)>;

// Runs all that is not yet kept, and returns all, kept ones included, sequence by sequence: all
// that were done where plan.stop ends it, for a run that it cuts off is none. Throws IoError for a
// sequence that cannot be used and for a kept run of other switches, and what the runs throw.
std::vector<RunRecord> RunSweep(const SweepPlan& plan, const GroupCallback& on_group = {});

}  // namespace highwall::bench
