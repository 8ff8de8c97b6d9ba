#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>

#include "paired_statistics.h"
#include "sweep_tables.h"

// Comparison of another system's trajectories with the runs of a sweep, on the same frames.
namespace highwall::bench {

struct ReferenceSystem {
  std::string name;
  std::filesystem::path folder;  // TUM trajectories: SEQUENCE_*.txt or SEQUENCE.txt, one per run
};
// Parses "NAME=DIR". Throws InvalidArgument.
ReferenceSystem ParseReference(const std::string& text);

// Returns its runs over one sequence, by their names; none if it has none. others: sequences whose
// runs are excluded although their names begin with the same text.
std::vector<Trajectory> ReferenceRuns(const ReferenceSystem& system, const std::string& sequence,
                                      const std::vector<std::string>& others);

// Frames of a sequence with the ground truth.
struct ScoredFrames {
  std::vector<Stamp> stamps;  // ascending
  Trajectory truth;
};

// Scores of the runs of one system over a sequence.
struct SystemScore {
  std::size_t runs = 0;
  double coverage = 0.0;                        // median share of the frames that have a pose
  double ape = 0.0, rpe_1 = 0.0, rpe_30 = 0.0;  // RMSE over the common frames [m], medians; RPE is
                                                // -1 where too few frames are common
};

struct Comparison {
  std::string sequence, setting, reference;
  SystemScore own, other;
  std::size_t frames = 0;
  std::size_t common = 0;        // with a pose in every run of both
  std::optional<MeanLog> ratio;  // of the APE, own over other
  std::string problem;           // why they are not compared; empty: they are
};

// Matches frames and poses within 10 ms. Each run is aligned separately, over the common frames.
Comparison Compare(const ScoredFrames& frames, const std::vector<Trajectory>& own,
                   const std::vector<Trajectory>& other);

// Compares each row with each system that has runs over its sequence. data: the folder of the
// sequences; generated ones are skipped. Throws IoError for a sequence that cannot be used or has
// no ground truth, a trajectory that cannot be read, and a system without a run over any.
std::vector<Comparison> CompareAll(const std::vector<SweepRow>& rows,
                                   const std::vector<ReferenceSystem>& systems,
                                   const std::filesystem::path& data);

// Returns a table, and below it the mean over the sequences for each setting and system.
std::string ToMarkdown(const std::vector<Comparison>& comparisons);
nlohmann::json ToJson(const std::vector<Comparison>& comparisons);

}  // namespace highwall::bench
