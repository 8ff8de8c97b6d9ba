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

// Result of a run of a sweep, and the file that stores it.
namespace highwall::bench {

struct NamedSetting {
  std::string name;      // letters, digits and -_.+: also the name of a folder
  std::string switches;  // arguments of `highwall slam`
  MapChoice map = MapChoice::kNone;
};

// Identifies a run.
struct RunKey {
  std::string sequence;  // seeds of one scene share it
  int seed = 0;          // of a generated sequence; 0: a recording
  NamedSetting setting;
  int run = 1;  // counted from 1
  bool synchronous = false;
  double live_rate = 0.0;  // as SettingMode::live_rate
};

struct RunRecord {
  RunKey key;
  Scores figures;
  std::map<std::string, std::size_t> loss_reasons;  // frames without a pose
  Trajectory trajectory;                            // of the largest map
};

// Returns "fr1_xyz/both/1" or "room_4s_30fps/seed2/both/1", with '/' in names replaced by '_'.
std::filesystem::path NameOf(const RunKey& key);
// Returns runs/NAME.json in the folder of a sweep; the trajectory is NAME.txt next to it.
std::filesystem::path RecordFile(const std::filesystem::path& sweep, const RunKey& key);

// Writes both files; the record is last and atomic. Throws IoError.
void WriteRecord(const std::filesystem::path& sweep, const RunRecord& record);
// Throws IoError for a file that cannot be read or is not a record.
RunRecord ReadRecord(const std::filesystem::path& file);
// Returns all records of sweeps, by their names: those of `sequences`, or of all if that is empty.
// Throws IoError, also for a sweep without any run, and for a duplicate run.
std::vector<RunRecord> MergeRecords(const std::vector<std::filesystem::path>& sweeps,
                                    const std::vector<std::string>& sequences = {});

}  // namespace highwall::bench
