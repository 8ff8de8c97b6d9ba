#pragma once

#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/pose/pose_report.h>

namespace [[gnu::visibility("default")]] highwall {

// The current online estimate of the sensor.
struct SensorEstimate {
  FrameTimingEstimate timing{};  // rolling shutter and delay of depth (TrackerOptions::timing)
  // Remaining depth distortion of the given images, which is corrected
  // (SlamOptions::depth_pattern): the correction to add to RgbdSensor::depth_pattern.
  DepthPattern depth_pattern{};
  NoiseEstimate noise{};  // of the observations (TrackerOptions::learn_noise)
};

}  // namespace highwall
