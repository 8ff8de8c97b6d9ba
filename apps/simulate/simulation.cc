#include "simulate/simulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <highwall/core/error.h>

namespace highwall::simulate {
namespace {

constexpr Stamp kFirstStamp = 1'000'000'000;  // [ns] not 0, which some tools take for "no stamp"
constexpr double kMaxFrames = 1e6;

}  // namespace

void SimulationOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(duration) && duration > 0.0,
                   "SimulationOptions::duration must be positive");
  HIGHWALL_REQUIRE(std::isfinite(fps) && fps > 0.0, "SimulationOptions::fps must be positive");
  HIGHWALL_REQUIRE(duration * fps <= kMaxFrames,
                   "SimulationOptions: duration times fps must not exceed a million frames");
  camera.Validate();
  sensor.Validate();
}

Simulation::Simulation(Scene scene, SplineTrajectory trajectory, const SimulationOptions& options)
    : options_((options.Validate(), options)),
      renderer_(std::move(scene), options.camera),
      trajectory_(std::move(trajectory)),
      sensor_(options.sensor, options.camera, options.seed) {}

int Simulation::size() const {
  return std::max(1, static_cast<int>(std::lround(options_.duration * options_.fps)));
}

Stamp Simulation::StampOf(int i) const {
  return kFirstStamp + 1000 * static_cast<Stamp>(std::llround(i * 1e6 / options_.fps));
}

Pose Simulation::T_WC(Stamp stamp) const {
  return trajectory_.T_WC(ToSeconds(stamp - kFirstStamp));
}

SimulatedFrame Simulation::Render(int i, int threads) const {
  HIGHWALL_REQUIRE(i >= 0 && i < size(), "Simulation::Render: no frame " + std::to_string(i));
  const Stamp stamp = StampOf(i);
  const Pose pose = T_WC(stamp);
  const SensorImages images = sensor_.Observe(renderer_.Render(pose, threads), i, threads);
  return {stamp, images.bgr, images.depth, pose};
}

}  // namespace highwall::simulate
