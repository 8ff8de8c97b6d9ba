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
  // frames                scored frames of the recording
  // without_pose          of those, frames without a pose in any map
  // first_without_pose    the first of those, as an index in the modified sequence; absent if none
  // maps                  final number of worlds with poses
  // merges, loops         accepted; merges count as loops
  // ape_rmse_m            of the map with most scored frames; absent with too few poses
  // drift_m_per_m         RMSE of the same over a metre of distance, over all pairs
  // elsewhere             frames inserted from another recording
  // elsewhere_taken_home  of those, frames with a pose in that map
  Scores figures;
  std::map<std::string, std::size_t> reasons;  // of all frames without a pose
};

// progress(done, total).
using ProgressCallback = std::function<void(std::size_t done, std::size_t total)>;

// Runs SlamSystem once over a sequence with a ground truth. synchronous: in synchronous mode, as
// `highwall slam --deterministic`. Throws the errors of Highwall.
AbuseScores RunAbused(const AbusedSequence& sequence, const RgbdSensor& sensor, bool synchronous,
                      const ProgressCallback& progress);

}  // namespace highwall::bench
