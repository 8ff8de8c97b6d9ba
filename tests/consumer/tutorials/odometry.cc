// Runs the program of docs/tutorial_odometry.md over points at rest; exits 0 if the camera stays.
#include <odometry/odometry.h>

int main() {
  const highwall::RgbdSensor sensor;
  Odometry odometry(sensor);
  std::vector<TrackedPoint> seen;
  for (int i = 0; i < 20; ++i) {
    highwall::PointFeature feature;
    feature.uv = {60.0 + 25.0 * i, 80.0 + 97.0 * (i % 4)};
    feature.depth = 1.5 + 0.1 * (i % 7);
    seen.push_back({i, feature});
  }
  for (highwall::Stamp k = 0; k < 5; ++k) {
    const auto T_WC = odometry.AddImage(k * 100'000'000, seen);
    if (!T_WC || T_WC->p().norm() > 1e-6) return 1;
  }
  return 0;
}
