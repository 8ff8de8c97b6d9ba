#pragma once

#include <filesystem>

#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"

namespace highwall::testing {

// A walk through the room at 30 frames per second, seen by a Kinect with a quarter of the pixels.
inline simulate::SimulationOptions SmallRoomOptions() {
  simulate::SimulationOptions options;
  options.imu.enabled = false;
  options.camera = {
      .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
  return options;
}

// The first frames of the walk as a TUM dataset.
inline void WriteSmallRoom(const std::filesystem::path& dataset, int frames) {
  simulate::SimulationOptions options = SmallRoomOptions();
  options.duration = frames / options.fps;
  simulate::WriteTum(simulate::SimulateRoom(options), dataset);
}

}  // namespace highwall::testing
