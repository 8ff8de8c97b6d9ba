#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/open_dataset.h>

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

// Opens a recording as OpenDataset() with its configuration: that which it states itself, or the
// one that ResolveConfig() finds by `choice`. max_pair_difference [s]: as
// DatasetOptions::max_stamp_difference. Throws IoError as both do, and for a choice where the
// recording states its own calibration.
OpenedDataset OpenWithConfig(const std::string& choice, const std::filesystem::path& directory,
                             double max_pair_difference = kMaxPairDifference);

}  // namespace highwall::apps
