#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory.h>

#include "medians.h"
#include "paired_setting.h"

// What a run of a sweep has come to, and the file in which it is kept.
namespace highwall::bench {

struct NamedSetting {
  std::string name;      // letters, digits and -_.+: a folder is called so
  std::string switches;  // what one would write behind `highwall slam`
  MapChoice map = MapChoice::kNone;
};

// Which run it is.
struct RunKey {
  std::string sequence;  // seeds of one scene share it
  int seed = 0;          // of a generated sequence; 0: a recording
  NamedSetting setting;
  int run = 1;  // counted from 1
  bool lockstep = false;
};

struct RunRecord {
  RunKey key;
  Scores figures;
  std::map<std::string, std::size_t> loss_reasons;  // frames without a pose
  Trajectory trajectory;                            // of the largest map
};

// "fr1_xyz/both/1" or "room_4s_30fps/seed2/both/1", '/' in names becoming '_'.
std::filesystem::path NameOf(const RunKey& key);
// runs/NAME.json in the folder of a sweep; the trajectory is NAME.txt beside it.
std::filesystem::path RecordFile(const std::filesystem::path& sweep, const RunKey& key);

// Both files; the record, whole or not at all, comes last. Throws IoError.
void WriteRecord(const std::filesystem::path& sweep, const RunRecord& record);
// Throws IoError for a file that cannot be read or is no record.
RunRecord ReadRecord(const std::filesystem::path& file);
// All records of sweeps, by their names: those of `sequences`, of all where there are none. Throws
// IoError, also for a sweep without any run, and for a run that two of them have.
std::vector<RunRecord> MergeRecords(const std::vector<std::filesystem::path>& sweeps,
                                    const std::vector<std::string>& sequences = {});

}  // namespace highwall::bench
