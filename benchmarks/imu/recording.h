#pragma once

#include <filesystem>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>

namespace highwall::bench {

struct TrueState {
  Stamp stamp = 0;
  ImuState state;
  ImuBias bias = ImuBias::Zero();
};

// Readings of an IMU with its ground-truth motion.
struct Recording {
  ImuBuffer imu;
  std::vector<TrueState> truth;
  bool has_biases = false;  // otherwise zero, and velocities are derived from positions
};

// Reads a folder with imu.csv (EuRoC) and either groundtruth.csv (EuRoC: position, orientation,
// velocity, biases) or groundtruth.txt (TUM: poses of the IMU). Throws IoError "path:line: what".
Recording ReadRecording(const std::filesystem::path& folder);

}  // namespace highwall::bench
