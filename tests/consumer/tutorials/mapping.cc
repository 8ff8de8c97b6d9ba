// Runs the program of docs/tutorial_mapping.md over three images of a wall; exits 0 if it is mapped.
#include <mapping/survey.h>

#include <cmath>

#include "wall.h"

int main() {
  const highwall::RgbdSensor sensor;
  std::int64_t next = 0;
  const auto maps = Survey(sensor, [&]() -> std::optional<highwall::RgbdImage> {
    if (next == 3) return std::nullopt;
    return Wall(next++ * 33'000'000, sensor.camera);
  });
  if (maps.size() != 1) return 1;
  const highwall::DenseMap& map = maps.begin()->second;
  // W has x along the optical axis of the first camera.
  for (const highwall::ColoredPoint& point : map.cloud) {
    if (std::abs(point.p.x() - 2.0f) > 0.05f) return 1;
  }
  return !map.cloud.empty() && map.octree.LeafCount().occupied > 0 ? 0 : 1;
}
