#pragma once

#include <filesystem>
#include <optional>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "input/frame_list_dataset.h"

namespace highwall {

// Images with neither lists nor stamps: color/N.png, rgb_png/N.png or rgb/N.png (or .jpg, .ppm)
// with depth/N.png, depth/N.pgm or depth_png/N.png of the same numbers.
class NumberedPairsDataset final : public FrameListDataset {
 public:
  // Returns whether the folder contains such files.
  static bool IsOne(const std::filesystem::path& folder);

  // Throws IoError if no numbers meet, and otherwise as
  // FrameListDataset.
  explicit NumberedPairsDataset(const std::filesystem::path& folder,
                                const std::optional<RgbdSensor>& sensor = std::nullopt,
                                const DatasetOptions& options = {});
};

}  // namespace highwall
