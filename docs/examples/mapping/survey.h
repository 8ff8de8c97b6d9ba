#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include <highwall/frontend/system/slam_system.h>
#include <highwall/mapping/dense_mapper.h>
#include <highwall/mapping/occupancy_grid.h>
#include <highwall/mapping/point_cloud_io.h>

// Waits for the next pair of images; empty when the camera has been switched off.
using Camera = std::function<std::optional<highwall::RgbdImage>()>;

// Cloud, octree and grid of the visible scene, by submap.
inline std::map<std::int32_t, highwall::DenseMap> Survey(const highwall::RgbdSensor& sensor,
                                                         const Camera& camera) {
  using namespace highwall;
  SlamSystem slam(sensor);
  DenseMapper mapper({}, {sensor.camera, [&](double z) { return sensor.depth_noise.Sigma(z); }});
  slam.SetCallbacks({.on_keyframes = [&](const KeyframeEvent& event) { mapper.Apply(event); }});
  while (const auto image = camera()) slam.Track(*image);
  slam.Finish();
  return mapper.Finish();
}

// Writes cloud_0.ply, map_0.bt, grid_0.yaml and its image, and those of the other submaps, to a
// folder that exists. Throws IoError where a file cannot be written.
inline void WriteSurvey(const std::map<std::int32_t, highwall::DenseMap>& maps,
                        const std::filesystem::path& folder) {
  for (const auto& [submap, map] : maps) {
    const std::string number = std::to_string(submap);
    highwall::WritePly(folder / ("cloud_" + number + ".ply"), map.cloud);
    map.octree.WriteBinary(folder / ("map_" + number + ".bt"));
    highwall::WriteOccupancyGrid(folder / ("grid_" + number + ".yaml"), map.grid);
  }
}
