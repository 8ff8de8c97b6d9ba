#pragma once

#include <highwall/frontend/input/sensor.h>
#include <highwall/mapping/keyframe_image.h>

namespace highwall::apps {

// The sensor as mapping knows it.
inline DepthCamera DepthCameraOf(const RgbdSensor& sensor) {
  return {sensor.camera, [noise = sensor.depth_noise](double z) { return noise.Sigma(z); }};
}

}  // namespace highwall::apps
