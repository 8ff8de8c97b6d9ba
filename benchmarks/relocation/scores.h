#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "encounters.h"
#include "parted_sequence.h"
#include "session.h"

namespace highwall::bench {

// Run over a complete sequence.
struct Run {
  std::vector<Outcome> outcomes;  // of every frame
  std::vector<Meeting> meetings;
  std::vector<Trajectory> trajectories;  // final, the one with most frames first
  std::vector<std::string> refusals;     // of loops and merges
  Encounters encounters;
};

// progress(done, total).
Run RunSequence(const PartedSequence& parted,
                const std::function<void(std::size_t, std::size_t)>& progress);

// Error of a relative pose with respect to the ground truth.
struct PlaceError {
  double millimetres = 0.0, degrees = 0.0;
};

struct RelocationScores {
  double gone_s = 0.0;   // from the start of a part to its first pose; the longest
  int lost = 0;          // frames without a pose
  int lost_covered = 0;  // of those, behind the cover
  int misplaced = 0;     // with a pose that is inconsistent with that of their map
  // Share of matched features in the first image after a cut with a pose in an earlier map; the
  // minimum.
  std::optional<double> matched_after_cut;
  double known_at_first = 0.0;     // of the second part: known share of its first image
  std::optional<double> due_s;     // since the first frame: a known place is seen again
  std::optional<double> merged_s;  // since then: two maps are merged
  int maps = 0;                    // final number
  int merges = 0, loops = 0;       // accepted
  int false_merges = 0, false_loops = 0;
  std::optional<double> ape_mm;     // of the largest map, aligned
  std::optional<PlaceError> merge;  // of the last one: its measured transform
  std::optional<PlaceError> parts;  // final relative pose of the first two, if in one map
  std::map<std::string, int> reasons, covered_reasons;  // of frames without a pose
};

RelocationScores ScoreRun(const PartedSequence& parted, const Run& run);

// Returns the RMSE of this run over the frames with a pose in both [mm].
std::optional<double> ApeOverSameFrames(const PartedSequence& parted, const Run& run,
                                        const PartedSequence& other_parted, const Run& other);

}  // namespace highwall::bench
