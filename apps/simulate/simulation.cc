#include "simulate/simulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <highwall/core/error.h>

namespace highwall::simulate {
namespace {

constexpr Stamp kFirstStamp = 1'000'000'000;  // [ns] not 0, which some tools take for "no stamp"
constexpr double kMaxFrames = 1e6;

// Frame i of `fps` a second.
Stamp StampOfFrame(int i, double fps) {
  return kFirstStamp + 1000 * static_cast<Stamp>(std::llround(i * 1e6 / fps));
}

int NumberOfFrames(const SimulationOptions& options) {
  return std::max(1, static_cast<int>(std::lround(options.duration * options.fps)));
}

}  // namespace

void SimulationOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(duration) && duration > 0.0,
                   "SimulationOptions::duration must be positive");
  HIGHWALL_REQUIRE(std::isfinite(fps) && fps > 0.0, "SimulationOptions::fps must be positive");
  HIGHWALL_REQUIRE(duration * fps <= kMaxFrames,
                   "SimulationOptions: duration times fps must not exceed a million frames");
  HIGHWALL_REQUIRE(std::isfinite(rest) && rest >= 0.0,
                   "SimulationOptions::rest must not be negative");
  camera.Validate();
  sensor.Validate();
  imu.Validate();
}

Simulation::Simulation(Scene scene, SplineTrajectory trajectory, const SimulationOptions& options,
                       VibrationIntensity intensity)
    : options_((options.Validate(), options)),
      renderer_(std::move(scene), options.camera),
      path_(std::move(trajectory), options.rest),
      intensity_(std::move(intensity)),
      sensor_(options.sensor, options.camera, options.seed),
      imu_(options.imu, options.seed, kFirstStamp,
           StampOfFrame(NumberOfFrames(options) - 1, options.fps)) {}

int Simulation::size() const {
  return NumberOfFrames(options_);
}

Stamp Simulation::StampOf(int i) const {
  return StampOfFrame(i, options_.fps);
}

Pose Simulation::T_WC(Stamp stamp) const {
  return path_.T_WC(ToSeconds(stamp - kFirstStamp));
}

SimulatedFrame Simulation::Render(int i, int threads) const {
  HIGHWALL_REQUIRE(i >= 0 && i < size(), "Simulation::Render: no frame " + std::to_string(i));
  const Stamp stamp = StampOf(i);
  const Pose pose = T_WC(stamp);
  const SensorImages images = sensor_.Observe(renderer_.Render(pose, threads), i, threads);
  return {stamp, images.bgr, images.depth, pose};
}

std::vector<ImuSample> Simulation::ImuSamples() const {
  if (!options_.imu.enabled) return {};
  return imu_.Samples(path_, intensity_);
}

TrueState Simulation::StateAt(Stamp stamp) const {
  return imu_.StateAt(path_, stamp);
}

}  // namespace highwall::simulate
