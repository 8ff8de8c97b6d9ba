#pragma once

#include <filesystem>
#include <optional>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "input/frame_list_dataset.h"

namespace highwall {

// A recording of Stray Scanner (iPhone or iPad with LiDAR): odometry.csv with the stamp and the
// pose of each image, camera_matrix.csv of the images of 1920 x 1440, depth/NNNNNN.png [mm] with
// confidence/NNNNNN.png, imu.csv, and the images as rgb.mp4 or as rgb/NNNNNN.png (or .jpg).
class StrayScannerDataset final : public FrameListDataset {
 public:
  // Returns whether the folder contains such files.
  static bool IsOne(const std::filesystem::path& folder);

  // Throws IoError naming the file if one is missing or malformed, and otherwise as
  // FrameListDataset.
  explicit StrayScannerDataset(const std::filesystem::path& folder,
                               const std::optional<RgbdSensor>& sensor = std::nullopt,
                               const DatasetOptions& options = {});
};

}  // namespace highwall
