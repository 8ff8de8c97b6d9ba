#pragma once

#include <filesystem>
#include <optional>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "input/frame_list_dataset.h"

namespace highwall {

// A recording in the layout of 7-Scenes and tsdf-fusion: frame-NNNNNN.color.png (or .jpg),
// frame-NNNNNN.depth.png [mm] and, where they exist, frame-NNNNNN.pose.txt (camera to world) and
// camera-intrinsics.txt, here or in the folder above. There are no stamps.
// Source: Shotton et al., "Scene Coordinate Regression Forests for Camera Relocalization in RGB-D
// Images", CVPR 2013.
class SevenScenesDataset final : public FrameListDataset {
 public:
  // Returns whether the folder contains such files.
  static bool IsOne(const std::filesystem::path& folder);

  // Throws IoError naming the file if one is malformed, and otherwise as
  // FrameListDataset.
  explicit SevenScenesDataset(const std::filesystem::path& folder,
                              const std::optional<RgbdSensor>& sensor = std::nullopt,
                              const DatasetOptions& options = {});
};

}  // namespace highwall
