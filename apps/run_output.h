#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory_log.h>

#include "slam_run.h"

namespace highwall::apps {

// trajectory.txt, trajectory_2.txt ...: the file of the largest submap (place 0) and of the others
// in their order.
std::string NameOfSubmap(const std::string& name, std::size_t place);

// Files in the folder of a run, or of runs that were merged.
inline constexpr const char* kReportFile = "run.json";
inline constexpr const char* kTrajectoryFile = "trajectory.txt";
inline constexpr const char* kCausalFile = "trajectory_causal.txt";
inline constexpr const char* kAdjustedFile = "trajectory_adjusted.txt";
inline constexpr const char* kKeyframesFile = "keyframes.txt";
inline constexpr const char* kCloudFile = "cloud.ply";
inline constexpr const char* kOctreeFile = "map.bt";
inline constexpr const char* kReportPage = "report.html";
inline constexpr const char* kSparseMapFile = "sparse_map.png";
inline constexpr const char* kMapFile = "map.hwmap";  // SaveMap
// In the folder of highwall map.
inline constexpr const char* kMapsReportFile = "map.json";

// trajectory_run1.txt, ...: what the run, counted from 0, has in the largest submap.
std::string TrajectoryOfRun(std::size_t run);

// Makes the folder where it is missing, and removes what an earlier run wrote there, all but
// `kept`: run.json first. Throws IoError.
void BeginFolder(const std::filesystem::path& folder,
                 std::span<const std::filesystem::path> kept = {});
// Whole or not at all. Throws IoError.
void WriteReport(const std::filesystem::path& folder, const nlohmann::json& report);

// The folder of a run. Nothing is touched before the first pose; from then on all that is in it is
// of this run: what an earlier one wrote goes, run.json first, and run.json comes last. Poses and
// keyframes are written as they come, so that a run that is killed leaves them; all else is written
// in the end, each file whole or not at all. One that cannot be written stops no other.
class RunOutput {
 public:
  // directory, and the folder of saved_map where that is not empty, are made where they are
  // missing. loaded_map, saved_map: not removed where they lie in the folder.
  explicit RunOutput(std::filesystem::path directory, std::filesystem::path saved_map = {},
                     std::filesystem::path loaded_map = {});

  // Adds to trajectory_causal.txt and keyframes.txt, where the frame is in the world of the first
  // one. Throws IoError where a folder cannot be made, or what an earlier run left cannot be
  // removed.
  void Follow(const FrameResult& result);
  // After the last frame: trajectory.txt, keyframes.txt as they are now, trajectory_causal.txt, of
  // the largest submap; those of the others are numbered from trajectory_2.txt on.
  void WriteTrajectories(const SlamRun& run);
  // After WriteTrajectories(), once: trajectory_adjusted.txt, cloud.ply, map.bt, grid.pgm and
  // grid.yaml, pictures, as far as the run has them, those of the other submaps numbered, and
  // run.json. Returns what that says: run_json, the sizes of the maps, `complete`, and `failures`
  // where there are any.
  nlohmann::json WriteRest(const SlamRun& run, const nlohmann::json& run_json);

  // What could not be made or written: those of the run, then of its files.
  const std::vector<std::string>& failures() const { return failures_; }

 private:
  void Begin();
  void OpenLog(const char* name, std::optional<TrajectoryLog>& log) const;
  // Does without what the file system refuses.
  void Attempt(const std::function<void()>& write);
  void WriteDense(const SubmapRun& submap, std::size_t place);

  std::filesystem::path directory_, saved_map_, loaded_map_;
  bool begun_ = false;
  std::optional<TrajectoryLog> causal_, keyframes_;  // empty: not open, or could not be written
  SubmapId logged_ = kNoId;                          // whose frames they hold
  std::vector<std::string> failures_;
};

}  // namespace highwall::apps
