// Runs the program of docs/tutorial_slam.md over three images of a wall; exits 0 if it follows.
#include <slam/pilot.h>

#include <chrono>
#include <cstdint>
#include <thread>

#include "wall.h"

class WallCamera final : public highwall::ImageSource {
 public:
  std::optional<highwall::RgbdImage> Next() override {
    if (next_ == 3) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(next_ == 0 ? 0 : 500));
    return Wall(next_++ * 33'000'000, {});
  }
  void Stop() override {}

 private:
  std::int64_t next_ = 0;
};

int main() {
  const highwall::RgbdSensor sensor;
  Pilot pilot(sensor);
  WallCamera camera;
  pilot.Run(camera);
  // Nothing moved.
  return pilot.here() && pilot.here()->p().norm() < 1e-3 && !pilot.places().empty() ? 0 : 1;
}
