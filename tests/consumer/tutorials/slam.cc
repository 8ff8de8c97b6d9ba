// Runs the program of docs/tutorial_slam.md over three images of a wall; exits 0 if it follows.
#include <slam.h>

#include <chrono>
#include <cstdint>
#include <random>

namespace {

// Blocks of random grey, 2 m away.
highwall::RgbdImage Wall(highwall::Stamp stamp, const highwall::PinholeCamera& camera) {
  highwall::RgbdImage image{stamp, cv::Mat(camera.height, camera.width, CV_8UC3),
                            cv::Mat(camera.height, camera.width, CV_32FC1, cv::Scalar(2.0))};
  std::mt19937 random(1);
  for (int v = 0; v < camera.height; v += 8) {
    for (int u = 0; u < camera.width; u += 8) {
      image.bgr(cv::Rect(u, v, 8, 8)).setTo(cv::Scalar::all(static_cast<double>(random() % 256)));
    }
  }
  return image;
}

}  // namespace

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
