// Runs the program of docs/tutorial_slam.md over three images of a wall; exits 0 if it follows.
#include <slam.h>

#include <chrono>
#include <cstdint>

#include "wall.h"

int main() {
  const highwall::RgbdSensor sensor;
  Pilot pilot(sensor);
  std::int64_t next = 0;
  pilot.Run([&]() -> std::optional<highwall::RgbdImage> {
    if (next == 3) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(next == 0 ? 0 : 500));
    return Wall(next++ * 33'000'000, sensor.camera);
  });
  // Nothing moved.
  return pilot.here() && pilot.here()->p().norm() < 1e-3 && !pilot.places().empty() ? 0 : 1;
}
