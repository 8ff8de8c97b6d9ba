#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>

#include <highwall/frontend/input/sensor.h>

#include "abused_sequence.h"
#include "medians.h"

namespace highwall::bench {

struct AbuseScores {
  // frames               of the recording that are scored
  // without_pose         of them, in any map
  // first_without_pose   the first of these, counted in frames of the changed sequence; absent:
  // none maps                 worlds with poses in the end merges, loops        accepted; merges
  // are loops too ape_rmse_m           of the map that has most scored frames; absent with too few
  // poses drift_m_per_m        the same over a metre of way, RMSE over all pairs elsewhere frames
  // cut in from another recording elsewhere_taken_home of them, with a pose in that map
  Scores figures;
  std::map<std::string, std::size_t> reasons;  // of all frames without a pose
};

// progress(done, total).
using ProgressCallback = std::function<void(std::size_t done, std::size_t total)>;

// One run of SlamSystem over a sequence that has a ground truth. lockstep: as `highwall slam
// --deterministic`. Throws what Highwall throws.
AbuseScores RunAbused(const AbusedSequence& sequence, const RgbdSensor& sensor, bool lockstep,
                      const ProgressCallback& progress);

}  // namespace highwall::bench
