#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include "run/opened_dataset.h"

namespace highwall::apps {

struct TumCopy {
  std::size_t frames = 0;     // written
  double depth_factor = 0.0;  // [1/m] of the depth images
  std::size_t poses = 0;      // of groundtruth.txt; 0: there is none
  std::size_t readings = 0;   // of imu.csv; 0: there is none
  // Frames with depth of lower confidence (RgbdImage::noise_factor), which the layout cannot state.
  std::size_t without_confidence = 0;
};

// Writes a recording in the layout of TUM RGB-D: rgb/ and depth/ as PNG with rgb.txt and depth.txt,
// calibration.yaml and, where the recording has them, groundtruth.txt, imu.csv (units and signs as
// ReadImu() returns them) and gps.csv. Depth is stored by the factor of the configuration if that
// represents it exactly, else by 5000, or by 1000 where it is farther than 13 m; it is corrected as
// the configuration says, and calibration.yaml states no correction. Frames that cannot be used are
// left out (Dataset::problems()). Everything is written to a temporary folder that is renamed at
// the end. progress(done, total) is called after each frame. Throws IoError if `folder` exists and
// is not an empty folder, if it cannot be written, and if no frame can be used.
TumCopy CopyAsTum(const OpenedDataset& recording, const std::filesystem::path& source,
                  const std::filesystem::path& folder,
                  const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace highwall::apps
