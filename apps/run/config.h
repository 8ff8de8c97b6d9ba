#pragma once

#include <filesystem>
#include <string>

#include <highwall/frontend/input/sensor.h>

namespace highwall::apps {

// Calibration of the sensors of a run.
using RunConfig = SensorCalibration;

struct ResolvedConfig {
  RunConfig config;
  std::string origin;  // human-readable source of the configuration
};

// Resolves the argument of --config: tum1, tum2, tum3, a file, or empty. If it is empty,
// calibration.yaml in the dataset's folder is used, otherwise the preset implied by the dataset's
// name. Throws IoError as ReadSensor(), and if no configuration is found.
ResolvedConfig ResolveConfig(const std::string& choice, const std::filesystem::path& dataset);

// Returns the --config choice of a run, from "calibration" in its run.json. It is empty if the
// dataset provided the configuration or the file no longer exists.
std::string ConfigOfRun(const std::string& calibration);

// Returns "tum1" if the folder, or an original recording named in its rgb.txt, is called freiburg1
// (or fr1_...), and so on; empty if neither matches.
std::string PresetFromName(const std::filesystem::path& dataset);

// Returns the path of calibration.yaml in the folder of a dataset.
std::filesystem::path CalibrationFile(const std::filesystem::path& dataset);

}  // namespace highwall::apps
