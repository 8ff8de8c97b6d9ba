#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

namespace highwall {

// What metadata.json of Record3D states. Lists have one element a frame, or none.
struct Record3dMetadata {
  PinholeCamera camera{};  // with the size of the colour images
  std::vector<Stamp> stamps{};
  double rate = 60.0;                        // [Hz] of recordings without stamps
  std::vector<std::optional<Pose>> poses{};  // T_WC, z forward; empty where tracking was lost
  std::vector<PinholeCamera> cameras{};      // where the focus moves
};

// Reads w, h, K, frameTimestamps, fps, poses (quaternion x y z w and position) and
// perFrameIntrinsicCoeffs. Throws IoError naming the file for another form, and if the lists have
// different lengths.
Record3dMetadata ReadRecord3dMetadata(const std::filesystem::path& path);

}  // namespace highwall
