#pragma once

#include <cstddef>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace highwall::apps {

// Returns trajectory.txt, trajectory_2.txt ...: the file of the submap at a place. Places are the
// order of the submaps, the largest first, from FirstPlace() on.
std::string NameOfSubmap(const std::string& name, std::size_t place);

// Returns the place of the first submap from run.json: 1 if a map was loaded and never recognized,
// since the files of place 0 are in the world of the loaded map; otherwise 0.
std::size_t FirstPlace(const nlohmann::json& report);

// Files in the folder of a single or merged run.
inline constexpr const char* kReportFile = "run.json";
inline constexpr const char* kTrajectoryFile = "trajectory.txt";
inline constexpr const char* kVelocitiesFile = "velocities.txt";
inline constexpr const char* kCausalFile = "trajectory_causal.txt";
inline constexpr const char* kCovariancesFile = "covariances_causal.txt";
inline constexpr const char* kAdjustedFile = "trajectory_adjusted.txt";
inline constexpr const char* kKeyframesFile = "keyframes.txt";
inline constexpr const char* kCloudFile = "cloud.ply";
inline constexpr const char* kOctreeFile = "map.bt";
inline constexpr const char* kReportPage = "report.html";
inline constexpr const char* kSparseMapFile = "sparse_map.png";
inline constexpr const char* kMapFile = "map.hwmap";  // SaveMap
// Files in the folder of highwall map.
inline constexpr const char* kMapsReportFile = "map.json";

// Returns trajectory_run1.txt, ...: frames of the run (counted from 0) in the largest submap.
std::string TrajectoryOfRun(std::size_t run);

}  // namespace highwall::apps
