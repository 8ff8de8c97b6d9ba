#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <highwall/frontend/input/dataset.h>

#include "run/config.h"

namespace highwall::apps {

// [s] default maximum time difference between colour and depth of a frame (--max-pair-difference).
inline constexpr double kMaxPairDifference = DatasetOptions().max_stamp_difference;

// Dataset with the configuration of its sensors.
struct OpenedDataset {
  std::unique_ptr<const Dataset> images;
  RunConfig config;
  std::string origin;  // human-readable source of the configuration
};

// Opens a folder in the layout of TUM RGB-D or EuRoC (EurocDataset); the latter provides its own
// configuration. choice: as in ResolveConfig(). max_pair_difference [s]: for the TUM layout. Throws
// IoError as ResolveConfig() and the dataset do; for EuRoC also if choice is not empty.
OpenedDataset OpenDataset(const std::string& choice, const std::filesystem::path& directory,
                          double max_pair_difference = kMaxPairDifference);

// Opens the same images with another depth factor, offset or size. Throws IoError as the dataset
// does.
std::unique_ptr<const Dataset> OpenImages(const std::filesystem::path& directory,
                                          const RgbdSensor& sensor,
                                          double max_pair_difference = kMaxPairDifference);

}  // namespace highwall::apps
