#pragma once

#include <filesystem>
#include <optional>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "input/frame_list_dataset.h"

namespace highwall {

// A recording of Open3D's recorders: color/NNNNNN.jpg (or image/, or .png), depth/NNNNNN.png [mm],
// camera_intrinsic.json or intrinsic.json, and trajectory.log with poses where it exists. There are
// no stamps.
// Source: Choi, Zhou, Koltun, "Robust Reconstruction of Indoor Scenes", CVPR 2015, whose recordings
// have the format of trajectory.log.
class Open3dDataset final : public FrameListDataset {
 public:
  // Returns whether the folder contains such files.
  static bool IsOne(const std::filesystem::path& folder);

  // Throws IoError naming the file if one is missing or malformed, and otherwise as
  // FrameListDataset.
  explicit Open3dDataset(const std::filesystem::path& folder,
                         const std::optional<RgbdSensor>& sensor = std::nullopt,
                         const DatasetOptions& options = {});
};

}  // namespace highwall
