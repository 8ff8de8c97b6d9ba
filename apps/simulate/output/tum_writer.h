#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "simulate/camera/simulation.h"
#include "simulate/output/gps_files.h"

namespace highwall::simulate {

// Depth images hold round(factor z) in 16 bits: 5000 z as TUM's do, 1000 z as a D435i's.
constexpr double kTumDepthFactor = 5000.0;
constexpr double kD435iDepthFactor = 1000.0;

struct TumOptions {
  // calibration.yaml tells the read-outs, and the delay and the offset of depth, which somebody who
  // has but the data sheets does not know.
  bool errors = false;
  std::optional<GpsOptions> gps{};  // writes gps.csv and groundtruth_gps.txt
};

// Writes the whole sequence as a TUM RGB-D dataset (docs/simulator.md): rgb/, depth/, rgb.txt,
// depth.txt, groundtruth.txt (T_WC at 100 Hz or more), calibration.yaml, stretches.csv (the
// hard parts), surface.ply, the true surface, and, where the IMU is enabled, imu.csv and
// groundtruth_state.csv. Everything goes to a temporary folder beside `folder` that is renamed at
// the end. progress(done, total), if given, is called after each frame, one call at a time. Throws
// IoError if `folder` exists and is not an empty folder, or cannot be written.
void WriteTum(const Simulation& simulation, const std::filesystem::path& folder,
              const std::function<void(int, int)>& progress = {}, const TumOptions& options = {});

}  // namespace highwall::simulate
