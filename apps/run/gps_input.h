#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/gps.h>
#include <highwall/frontend/system/slam_system.h>

#include "run/config.h"

namespace highwall::apps {

// GPS data of a recording; fixes in ascending order of their stamps.
struct GpsFeed {
  std::vector<GpsFix> fixes;
  Eigen::Vector3d antenna_B = Eigen::Vector3d::Zero();  // [m] in the estimated body frame B
  Pose T_CB;                                            // pose of B in the camera frame
};

// GPS statistics of a run.
struct GpsSummary {
  std::size_t fixes = 0, used = 0, refused = 0;
  std::optional<Pose> T_GW;  // to the world of the trajectory; empty if unknown
  double rms = 0.0;          // [m] between antenna and fix, all axes, if T_GW is known
};

// Reads gps.csv in the folder of a dataset; empty if there is none. with_imu: the body frame is the
// IMU's, otherwise the camera's. Throws IoError as ReadGps().
std::optional<GpsFeed> LoadGps(const std::filesystem::path& dataset, const RunConfig& config,
                               bool with_imu);

// PoseFactor::source of the fixes.
inline constexpr char kGpsSource[] = "gps";

// Returns a fix as a robust factor: near walls the errors of a receiver far exceed its stated
// accuracy.
PoseFactor MakeGpsFactor(const GpsFix& fix, const Eigen::Vector3d& antenna_B,
                         ReferenceFrameId frame);

// counts: of kGpsSource. trajectory: final T_WC.
GpsSummary SummarizeGps(const GpsFeed& feed, const FactorCounts& counts,
                        const std::optional<Pose>& T_GW, const Trajectory& trajectory);

}  // namespace highwall::apps
