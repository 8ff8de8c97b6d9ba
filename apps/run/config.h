#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <opencv2/core/types.hpp>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall::apps {

// Calibration of the sensors of a run.
using RunConfig = SensorCalibration;

struct ResolvedConfig {
  RunConfig config;
  std::string origin;  // human-readable source of the configuration
  // One line about a file of another system: what it is, and where the values are from that it does
  // not state. Empty otherwise.
  std::string note{};
};

// Returns the configuration of a dataset without --config: calibration.yaml in its folder,
// otherwise the preset implied by its name; empty without both. options: of OpenDataset(), where a
// file does not state the size of the images. Throws IoError as ReadSensor().
std::optional<ResolvedConfig> OwnConfig(const std::filesystem::path& dataset,
                                        const DatasetOptions& options = {});

// Resolves the argument of --config: tum1, tum2, tum3, a file that ReadSensor() reads, or empty. If
// it is empty, the result is OwnConfig(). What a file of another system does not state is taken
// from OwnConfig(), and the size of the images from these. options: as in OwnConfig(). Throws
// IoError as ReadSensor(), and if no configuration is found.
ResolvedConfig ResolveConfig(const std::string& choice, const std::filesystem::path& dataset,
                             const DatasetOptions& options = {});

// Resolves a --config that is not empty, for a camera that delivers images of this size [px], which
// a file of another system need not state. Throws IoError as ReadSensor(), and for a name that is
// neither a file nor a preset.
ResolvedConfig ResolveCameraConfig(const std::string& choice, const cv::Size& image_size);

// Returns the --config choice of a run, from "calibration" in its run.json. It is empty if the
// dataset provided the configuration or the file no longer exists.
std::string ConfigOfRun(const std::string& calibration);

// Returns "tum1" if the folder, or an original recording named in its rgb.txt, is called freiburg1
// (or fr1_...), and so on; empty if neither matches.
std::string PresetFromName(const std::filesystem::path& dataset);

// Returns the path of calibration.yaml in the folder of a dataset.
std::filesystem::path CalibrationFile(const std::filesystem::path& dataset);

}  // namespace highwall::apps
