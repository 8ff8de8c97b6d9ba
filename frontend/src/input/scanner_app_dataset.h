#pragma once

#include <filesystem>
#include <optional>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "input/frame_list_dataset.h"

namespace highwall {

// A recording of 3D Scanner App (iPhone or iPad with LiDAR, "all data"): frame_NNNNN.json with the
// time, the camera matrix and the pose, depth_NNNNN.png [mm] with conf_NNNNN.png, and
// frame_NNNNN.jpg for some of them.
class ScannerAppDataset final : public FrameListDataset {
 public:
  // Returns whether the folder contains such files.
  static bool IsOne(const std::filesystem::path& folder);

  // Throws IoError naming the file if one is missing or malformed, and otherwise as
  // FrameListDataset.
  explicit ScannerAppDataset(const std::filesystem::path& folder,
                             const std::optional<RgbdSensor>& sensor = std::nullopt,
                             const DatasetOptions& options = {});
};

}  // namespace highwall
