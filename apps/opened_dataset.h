#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "config.h"

namespace highwall::apps {

// [s] Between colour and depth of a frame, unless --max-pair-difference says otherwise.
inline constexpr double kMaxPairDifference = TumDatasetOptions::kMaxStampDifference;

// A dataset and what is known of its sensors.
struct OpenedDataset {
  std::unique_ptr<const Dataset> images;
  RunConfig config;
  std::string origin;  // of the configuration, for people
};

// A folder in the layout of TUM RGB-D or of EuRoC (EurocDataset), which brings its own
// configuration. choice: as ResolveConfig(). max_pair_difference [s]: of TUM's layout. Throws
// IoError as ResolveConfig() and as the dataset; for EuRoC too where choice is not empty.
OpenedDataset OpenDataset(const std::string& choice, const std::filesystem::path& directory,
                          double max_pair_difference = kMaxPairDifference);

// The same images with another depth factor, offset or size. Throws IoError as the dataset.
std::unique_ptr<const Dataset> OpenImages(const std::filesystem::path& directory,
                                          const RgbdSensor& sensor,
                                          double max_pair_difference = kMaxPairDifference);

}  // namespace highwall::apps
