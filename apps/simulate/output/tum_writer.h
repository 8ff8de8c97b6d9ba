#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "simulate/camera/simulation.h"
#include "simulate/output/gps_files.h"

namespace highwall::simulate {

// Depth images contain round(factor z) in 16 bits: 5000 z as TUM's, 1000 z as a D435i's.
constexpr double kTumDepthFactor = 5000.0;
constexpr double kD435iDepthFactor = 1000.0;

struct TumOptions {
  // calibration.yaml contains the read-outs, and the delay and the offset of depth, which are
  // unknown to a user who only has the data sheets.
  bool errors = false;
  bool portrait = false;            // images turned as Portrait() describes; not with gps
  std::optional<GpsOptions> gps{};  // writes gps.csv and groundtruth_gps.txt
};

// Writes the whole sequence as a TUM RGB-D dataset (docs/simulator.md): rgb/, depth/, rgb.txt,
// depth.txt, groundtruth.txt (T_WC at 100 Hz or more), calibration.yaml, stretches.csv (the
// difficult parts), surface.ply (the true surface) and, if the IMU is enabled, imu.csv and
// groundtruth_state.csv. Everything is written to a temporary folder next to `folder` that is
// renamed at the end. progress(done, total), if given, is called after each frame, one call at a
// time. Throws IoError if `folder` exists and is not an empty folder, or cannot be written.
void WriteTum(const Simulation& simulation, const std::filesystem::path& folder,
              const std::function<void(int, int)>& progress = {}, const TumOptions& options = {});

}  // namespace highwall::simulate
