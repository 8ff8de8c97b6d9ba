#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/loops/merge_maps.h>

#include "run/finished_run.h"

namespace highwall::apps {

// Data of the sessions in one world.
struct MergedWorld {
  SubmapId root = kNoId;
  std::vector<Trajectory> frames;        // T_WC by session, empty if it has none here
  std::vector<std::size_t> in_one_file;  // sessions in trajectory.txt, in their order
};

// Merged finished runs.
struct MergedRuns {
  std::vector<FinishedRun> runs;  // without their maps
  std::vector<Session> sessions;  // of all runs, frames anchored to keyframes of `merged`
  PinholeCamera camera;           // shared by all
  MergedMaps merged;
  std::vector<MergedWorld> worlds;  // descending by number of frames

  // Returns the run that a keyframe of the merged map belongs to.
  std::size_t RunOf(KeyFrameId keyframe) const;
  // Whether the world contains keyframes of the run.
  bool IsIn(std::size_t run, const MergedWorld& world) const;
};

// Throws IoError if the runs do not share one camera, or if two contain the same keyframes, which
// would be duplicated in the merged map.
MergedRuns MergeRuns(std::vector<FinishedRun> runs, const MergeProgress& progress = {});

// Creates the folder and writes map.hwmap; for each world trajectory.txt and keyframes.txt, and for
// each session trajectory_run1.txt and so on (those of the second world are numbered
// trajectory_2.txt, trajectory_run1_2.txt); sparse_map.png and, last, run.json, which is returned.
// Sessions with overlapping stamps cannot share one trajectory.txt: it then contains the one with
// most frames. Throws IoError.
nlohmann::json WriteMergedRuns(const std::filesystem::path& folder, const MergedRuns& runs);

}  // namespace highwall::apps
