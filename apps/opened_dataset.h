#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <highwall/frontend/input/dataset.h>

#include "config.h"

namespace highwall::apps {

// A dataset and what is known of its sensors.
struct OpenedDataset {
  std::unique_ptr<const Dataset> images;
  RunConfig config;
  std::string origin;  // of the configuration, for people
};

// A folder in the layout of TUM RGB-D or of EuRoC (EurocDataset), which brings its own
// configuration. choice: as ResolveConfig(). Throws IoError as that and as the dataset; for EuRoC
// too where choice is not empty.
OpenedDataset OpenDataset(const std::string& choice, const std::filesystem::path& directory);

// The same images with another depth factor, offset or size. Throws IoError as the dataset.
std::unique_ptr<const Dataset> OpenImages(const std::filesystem::path& directory,
                                          const RgbdSensor& sensor);

}  // namespace highwall::apps
