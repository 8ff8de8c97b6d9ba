#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/frontend/system/slam_system.h>

#include "medians.h"
#include "run/slam_run.h"
#include "simulated_sequence.h"

namespace highwall::bench {

// Runs the system on a sequence as `highwall slam --deterministic --no-map` does.
apps::SlamRun RunOver(const SimulatedSequence& sequence, const SlamOptions& slam, bool imu);

// Computes ape_rmse_m, rpe_1s_rmse_m and lost_frames of the frames with stamps in [begin, end].
Scores ScorePart(const SimulatedSequence& sequence, const apps::SlamRun& run, Stamp begin,
                 Stamp end);
Scores ScoreAll(const SimulatedSequence& sequence, const apps::SlamRun& run);

// Scores over several seeds, by configuration.
class Table {
 public:
  // Also prints a line on standard error.
  void Add(const std::string& name, int seed, Scores scores);
  // Returns name: {"median": scores, "runs": [scores and seed]}.
  nlohmann::json ToJson() const;

 private:
  std::map<std::string, std::vector<Scores>> runs_;
};

}  // namespace highwall::bench
