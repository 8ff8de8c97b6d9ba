#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/gps.h>
#include <highwall/frontend/system/slam_system.h>

#include "config.h"

namespace highwall::apps {

// The GPS of a recording: fixes in the order of their stamps.
struct GpsFeed {
  std::vector<GpsFix> fixes;
  Eigen::Vector3d antenna_B = Eigen::Vector3d::Zero();  // [m] in the body whose poses are estimated
  Pose T_CB;                                            // that body in the camera
};

// How the GPS fared over a run.
struct GpsSummary {
  std::size_t fixes = 0, used = 0, refused = 0;
  std::optional<Pose> T_GW;  // in the world of the trajectory; empty where it was not found
  double rms = 0.0;          // [m] between antenna and fix, all axes, where T_GW is known
};

// gps.csv in the folder of a dataset; empty where there is none. with_imu: the body is that of the
// IMU, else the camera. Throws IoError as ReadGps.
std::optional<GpsFeed> LoadGps(const std::filesystem::path& dataset, const RunConfig& config,
                               bool with_imu);

// A fix as a factor: robust, for between walls a receiver errs by far more than it says.
PoseFactor MakeGpsFactor(const GpsFix& fix, const Eigen::Vector3d& antenna_B,
                         ReferenceFrameId frame);

// trajectory: T_WC in the end.
GpsSummary SummarizeGps(const GpsFeed& feed, const FactorCounts& counts,
                        const std::optional<Pose>& T_GW, const Trajectory& trajectory);

}  // namespace highwall::apps
