#pragma once

#include <algorithm>

#include <highwall/frontend/input/sensor.h>
#include <highwall/mapping/dense_mapper.h>
#include <highwall/mapping/depth_camera.h>

namespace highwall::apps {

// Returns the camera model that mapping uses for this sensor.
inline DepthCamera DepthCameraOf(const RgbdSensor& sensor) {
  return {sensor.camera, [noise = sensor.depth_noise](double z) { return noise.Sigma(z); }};
}

// Restricts the map to depth within the sensor's range.
inline void LimitToRange(const RgbdSensor& sensor, DenseMapOptions* map) {
  map->cloud.min_depth = map->octree.min_depth = sensor.min_depth;
  map->cloud.max_depth = std::min(map->cloud.max_depth, sensor.max_depth);
}

}  // namespace highwall::apps
