#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/open_dataset.h>

#include "run/config.h"

namespace highwall::apps {

// [s] default maximum time difference between colour and depth of a frame (--max-pair-difference).
inline const double kMaxPairDifference = DatasetOptions().max_stamp_difference;
// [Hz] default rate of frames without stamps (--fps).
inline const double kFrameRate = DatasetOptions().frame_rate;

// Dataset with the configuration of its sensors.
struct OpenedDataset {
  std::unique_ptr<const Dataset> images;
  RunConfig config;
  std::string origin;  // human-readable source of the configuration
  std::string note{};  // as in ResolvedConfig
};

// Prints to standard error the topics that are read of a bag, as --topics takes them, and what is
// taken from where with a calibration of another system; nothing for other recordings.
void PrintSources(const std::string& command, const OpenedDataset& opened);

// Opens a recording as OpenDataset() with its configuration: that of `choice` or of a
// calibration.yaml in its folder, else that which it states itself, else the one that
// ResolveConfig() finds. What a file of another system does not state is taken from what the
// recording states, unless ResolveConfig() has found it. The IMU is the one that the recording
// states, if the configuration has none. Throws IoError as both do, and for a choice where the
// frames are computed with the recording's own calibration (DatasetReader::fixed_camera).
OpenedDataset OpenWithConfig(const std::string& choice, const std::filesystem::path& directory,
                             const DatasetOptions& options = {});

}  // namespace highwall::apps
