#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "run/slam_run.h"

namespace highwall::bench {

// A recording with the right configuration. The images have a ground truth.
struct TrueRecording {
  std::string name;  // "room 1"
  std::shared_ptr<const Dataset> images;
  RgbdSensor sensor;
  std::optional<apps::ImuFeed> imu;  // empty if there is none
};

struct GeneratedRecording {
  std::string scene = "room";  // mine, road or room
  int seed = 1;
  double seconds = 10.0;     // > 0
  double depth_delay = 0.0;  // [s] by which depth images are taken later than their stamps say
};

// Generates a recording with half the pixels of a Kinect or D435i per side, at 30 Hz, and keeps its
// images in memory.
TrueRecording Generate(const GeneratedRecording& options);

// Opens a recording of a known calibration, its first `seconds`. Throws IoError, also without a
// ground truth.
TrueRecording OpenRecording(const std::filesystem::path& folder, double seconds);

}  // namespace highwall::bench
