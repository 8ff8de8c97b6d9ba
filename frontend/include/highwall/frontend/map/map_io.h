#pragma once

#include <filesystem>

#include <highwall/core/camera.h>
#include <highwall/frontend/map/map.h>

namespace highwall {

// A map and the camera whose images it is of.
struct SavedMap {
  PinholeCamera camera;  // without distortion: features are undistorted
  Map map;
};

// Writes keyframes with their features, points and lines: docs/map_file.md. The file appears whole
// or not at all. camera: as above; its distortion is not kept. Throws IoError.
void SaveMap(const std::filesystem::path& path, const PinholeCamera& camera, const Map& map);

// What SaveMap wrote; keyframes and landmarks get new ids, without gaps, in the old order. Throws
// IoError for a file that is missing, no map, of another version, cut short or damaged.
SavedMap LoadMap(const std::filesystem::path& path);

}  // namespace highwall
