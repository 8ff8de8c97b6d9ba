#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <highwall/core/trajectory_log.h>

#include "run/covariance_log.h"
#include "run/run_files.h"
#include "run/slam_run.h"

namespace highwall::apps {

// Returns FirstPlace() of a run whose report is not written yet.
std::size_t FirstPlace(const SlamRun& run);

// Creates a missing folder, and removes the results of an earlier run, except `kept`: run.json
// first. Throws IoError.
void BeginFolder(const std::filesystem::path& folder,
                 std::span<const std::filesystem::path> kept = {});
// Writes run.json atomically. Throws IoError.
void WriteReport(const std::filesystem::path& folder, const nlohmann::json& report);

// Output folder of a run. Nothing is touched before the first pose; from then on all results in it
// belong to this run: those of an earlier run are removed, run.json first, and the new run.json is
// written last. Poses and keyframes are written as they arrive, so that a killed run leaves them;
// everything else is written at the end, each file atomically. A file that cannot be written does
// not stop the others.
class RunOutput {
 public:
  // directory, and the folder of saved_map if not empty, are created if missing. loaded_map,
  // saved_map: not removed if they are in the folder.
  explicit RunOutput(std::filesystem::path directory, std::filesystem::path saved_map = {},
                     std::filesystem::path loaded_map = {});

  // Call before the first frame: Follow() then writes covariances_causal.txt as well, of all frames
  // with a pose.
  void KeepCovariances() { keeps_covariances_ = true; }

  // Appends to trajectory_causal.txt and keyframes.txt if the frame is in the world of the first
  // pose; if that is not the loaded one, to those of the second place. Throws IoError if a folder
  // cannot be created, or if the results of an earlier run cannot be removed.
  void Follow(const FrameResult& result);
  // Call after the last frame: writes trajectory.txt, velocities.txt, the final keyframes.txt, and
  // trajectory_causal.txt of the largest submap; those of the others are numbered from
  // trajectory_2.txt on.
  void WriteTrajectories(const SlamRun& run);
  // Call once after WriteTrajectories(): writes trajectory_adjusted.txt, cloud.ply, map.bt,
  // grid.pgm, grid.yaml and pictures where the run has them (those of the other submaps are
  // numbered), and run.json. Returns the content of the latter: run_json, the sizes of the maps,
  // `complete`, and `failures` if there are any.
  nlohmann::json WriteRest(const SlamRun& run, const nlohmann::json& run_json);

  // Failures to create or write results: those of the run, then of its files.
  const std::vector<std::string>& failures() const { return failures_; }

 private:
  void Begin();
  void OpenLog(const char* name, std::optional<TrajectoryLog>& log) const;
  std::filesystem::path PathAt(const char* name, std::size_t place) const;
  // Continues if the file system fails.
  void Attempt(const std::function<void()>& write);
  void WriteDense(const SubmapRun& submap, std::size_t place);

  std::filesystem::path directory_, saved_map_, loaded_map_;
  bool begun_ = false;
  bool keeps_covariances_ = false;
  std::optional<CovarianceLog> covariances_;
  std::optional<TrajectoryLog> causal_, keyframes_;  // empty: not open, or could not be written
  SubmapId logged_ = kNoId;                          // submap whose frames they contain
  std::size_t logged_place_ = 0;                     // in their names
  std::vector<std::string> failures_;
};

}  // namespace highwall::apps
