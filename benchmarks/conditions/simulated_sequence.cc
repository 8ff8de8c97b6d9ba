#include "simulated_sequence.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include <opencv2/core.hpp>

#include "scenes.h"

namespace highwall::bench {

SimulatedSequence::SimulatedSequence(const simulate::Simulation& simulation, double begin)
    : sensor_{.camera = simulation.options().camera,
              .depth_noise = simulation.options().sensor.Noise()} {
  constexpr Stamp kBefore = 500'000'000;  // [ns]
  const Stamp first = simulation.StampOf(0) + FromSeconds(begin);
  for (int i = 0; i < simulation.size(); ++i) {
    if (simulation.StampOf(i) < first) continue;
    simulate::SimulatedFrame frame = simulation.Render(i);
    images_.push_back({frame.stamp, frame.bgr, frame.depth});
    truth_.push_back({frame.stamp, frame.T_WC});
  }
  imu_.calibration = CalibrationOf(simulation.options().imu);
  std::ranges::copy_if(simulation.ImuSamples(), std::back_inserter(imu_.samples),
                       [&](const ImuSample& sample) { return sample.stamp >= first - kBefore; });
}

SimulatedSequence::SimulatedSequence(const SimulatedSequence& sequence, std::size_t first)
    : sensor_(sequence.sensor_),
      imu_(sequence.imu_),
      images_(sequence.images_.begin() + static_cast<std::ptrdiff_t>(first),
              sequence.images_.end()),
      truth_(sequence.truth_.begin() + static_cast<std::ptrdiff_t>(first), sequence.truth_.end()) {}

void SimulatedSequence::ScaleDepth(double factor) {
  for (RgbdImage& image : images_) image.depth *= factor;
}

}  // namespace highwall::bench
