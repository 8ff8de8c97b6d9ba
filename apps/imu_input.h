#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/imu_check.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall::apps {

// The IMU of a dataset, as far as it can be used.
struct ImuInput {
  std::filesystem::path file;
  ImuCalibration calibration;      // without a range that the readings leave
  std::vector<ImuSample> samples;  // RepairImu(): in order, each stamp once, finite
  std::vector<ImuFinding> findings;
  std::vector<std::string> warnings;  // for people, a line each, naming the file

  // Otherwise go on with RGB-D alone: the warnings say why.
  bool IsUsable() const { return !HasFatal(findings); }
};

// Reads and checks the IMU of a dataset; empty where it has none. calibration: what the
// configuration says; nothing makes the camera's axes those of the IMU, with a warning.
// Throws IoError as ReadImu.
std::optional<ImuInput> LoadImu(const Dataset& dataset,
                                const std::optional<ImuCalibration>& calibration);

}  // namespace highwall::apps
