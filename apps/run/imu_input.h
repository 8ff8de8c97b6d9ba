#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/imu_check.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/input/sensor_verdict.h>

namespace highwall::apps {

// Usable IMU data of a dataset.
struct ImuInput {
  std::filesystem::path file;
  ImuCalibration calibration;      // without a range that the readings exceed
  std::vector<ImuSample> samples;  // RepairImu(): ascending, unique stamps, finite
  std::vector<ImuFinding> findings;
  std::vector<std::string> warnings;  // human-readable, one per line, naming the file

  // If false, the run continues with RGB-D only; the warnings give the reason.
  bool IsUsable() const { return !HasFatal(findings); }
};

// Returns the kind of a finding in the verdict of a run.
SensorFault FaultOf(ImuFindingKind kind);

// Checks readings and repairs them, as LoadImu() does for those of a file. images: the stamps of
// the first and the last, in the clock of the camera. rate: stated [Hz], 0 if none is.
ImuInput CheckReadings(std::span<const ImuSample> readings, const ImuCalibration& calibration,
                       const VideoSpan& images, double rate);

// Reads and checks the IMU of a dataset; empty if it has none. calibration: from the configuration;
// without one, the axes of the camera are assumed to be those of the IMU, with a warning. Throws
// IoError as ReadImu().
std::optional<ImuInput> LoadImu(const Dataset& dataset,
                                const std::optional<ImuCalibration>& calibration);

}  // namespace highwall::apps
