#pragma once

#include <filesystem>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

namespace highwall {

// What frame_NNNNN.json of 3D Scanner App states.
struct ScannerAppFrame {
  Stamp stamp = 0;
  PinholeCamera camera{};  // of an image of unknown size, 0 x 0
  Pose T_WC;               // z forward
};

// Reads "time" [s], "intrinsics" and "cameraPoseARFrame" (row by row). Throws IoError naming the
// file for another form.
ScannerAppFrame ReadScannerAppFrame(const std::filesystem::path& path);

}  // namespace highwall
