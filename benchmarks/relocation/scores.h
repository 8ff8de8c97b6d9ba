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

// A sequence from its first frame to its last.
struct Run {
  std::vector<Outcome> outcomes;  // of every frame
  std::vector<Meeting> meetings;
  std::vector<Trajectory> trajectories;  // in the end, the one with most frames first
  std::vector<std::string> refusals;     // of loops and merges
  Encounters encounters;
};

// progress(done, total).
Run RunSequence(const PartedSequence& parted,
                const std::function<void(std::size_t, std::size_t)>& progress);

// Where one thing lies by another, against the truth.
struct PlaceError {
  double millimetres = 0.0, degrees = 0.0;
};

struct RelocationScores {
  double gone_s = 0.0;   // from where a part begins to the first pose in it; the longest of them
  int lost = 0;          // frames without a pose
  int lost_covered = 0;  // of them, behind the cover
  int misplaced = 0;     // with a pose that is not where their map has them
  // Of the first image after a cut that has a pose in a map of before: share of its features that
  // were matched, the least of them.
  std::optional<double> matched_after_cut;
  double known_at_first = 0.0;     // of the second part: share of its first image seen before
  std::optional<double> due_s;     // since the first frame: a known place is seen again
  std::optional<double> merged_s;  // since then: two maps have become one
  int maps = 0;                    // in the end
  int merges = 0, loops = 0;       // accepted
  int false_merges = 0, false_loops = 0;
  std::optional<double> ape_mm;     // of the largest map, aligned
  std::optional<PlaceError> merge;  // of the last one: the transform that was measured
  std::optional<PlaceError> parts;  // in the end: of the first two, where they are in one map
  std::map<std::string, int> reasons, covered_reasons;  // of frames without a pose
};

RelocationScores ScoreRun(const PartedSequence& parted, const Run& run);

// RMSE over the frames that both have a pose for [mm], of this run.
std::optional<double> ApeOverSameFrames(const PartedSequence& parted, const Run& run,
                                        const PartedSequence& other_parted, const Run& other);

}  // namespace highwall::bench
