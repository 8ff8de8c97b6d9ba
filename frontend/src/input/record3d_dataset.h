#pragma once

#include <filesystem>
#include <optional>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "input/frame_list_dataset.h"

namespace highwall {

// A recording of Record3D (iPhone or iPad with LiDAR or a TrueDepth camera), exported as EXR and
// RGB: metadata.json, rgb/N.jpg (or .png) and depth/N.exr [m].
class Record3dDataset final : public FrameListDataset {
 public:
  // Returns whether the folder contains such files.
  static bool IsOne(const std::filesystem::path& folder);

  // Throws IoError naming the file if one is missing or malformed, and otherwise as
  // FrameListDataset.
  explicit Record3dDataset(const std::filesystem::path& folder,
                           const std::optional<RgbdSensor>& sensor = std::nullopt,
                           const DatasetOptions& options = {});
};

}  // namespace highwall
