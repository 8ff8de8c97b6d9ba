#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/loops/merge_maps.h>

#include "finished_run.h"

namespace highwall::apps {

// What the sessions have in one world.
struct MergedWorld {
  SubmapId root = kNoId;
  std::vector<Trajectory> frames;        // T_WC by session, empty where it has none here
  std::vector<std::size_t> in_one_file;  // sessions that trajectory.txt holds, in their order
};

// Finished runs as one.
struct MergedRuns {
  std::vector<FinishedRun> runs;  // without their maps
  std::vector<Session> sessions;  // of all runs, their frames relative to keyframes of `merged`
  PinholeCamera camera;           // of all
  MergedMaps merged;
  std::vector<MergedWorld> worlds;  // that of most frames first

  // The run that a keyframe of the merged map is of.
  std::size_t RunOf(KeyFrameId keyframe) const;
  // Whether some of its keyframes are in the world.
  bool IsIn(std::size_t run, const MergedWorld& world) const;
};

// Throws IoError where the runs are not of one camera, or where two hold the same keyframes: in the
// map of both everything would be there twice.
MergedRuns MergeRuns(std::vector<FinishedRun> runs, const MergeProgress& progress = {});

// Makes the folder and writes map.hwmap; for each world trajectory.txt and keyframes.txt, and for
// each session trajectory_run1.txt and so on, those of the second world numbered trajectory_2.txt,
// trajectory_run1_2.txt; sparse_map.png and, last, run.json, which is returned. Sessions whose
// stamps overlap do not go into one trajectory.txt: it then holds the one with most frames. Throws
// IoError.
nlohmann::json WriteMergedRuns(const std::filesystem::path& folder, const MergedRuns& runs);

}  // namespace highwall::apps
