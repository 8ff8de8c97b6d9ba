#include "scenes.h"

#include <cstdint>

#include <simulate/room.h>

namespace highwall::bench {

PinholeCamera SmallCamera() {
  return {.width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
}

simulate::Simulation MakeRoom(int seed, double seconds) {
  simulate::SimulationOptions options;
  options.seed = static_cast<std::uint64_t>(seed);
  options.duration = seconds;
  options.fps = 10.0;
  options.camera = SmallCamera();
  options.sensor.noise = simulate::SensorNoise::kKinect;
  return simulate::SimulateRoom(options);
}

}  // namespace highwall::bench
