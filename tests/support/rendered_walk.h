#pragma once

#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "simulate/camera/simulation.h"

namespace highwall::testing {

// The recording of a simulated camera with its true trajectory.
struct RenderedWalk {
  std::vector<RgbdImage> images;
  std::vector<ImuSample> readings;
  Trajectory truth;  // T_WC of the images
  ImuCalibration calibration;
};

inline RenderedWalk Render(const simulate::Simulation& simulation) {
  RenderedWalk walk;
  for (int i = 0; i < simulation.size(); ++i) {
    const simulate::SimulatedFrame frame = simulation.Render(i);
    walk.images.push_back({frame.stamp, frame.bgr, frame.depth});
    walk.truth.push_back({frame.stamp, frame.T_WC});
  }
  walk.readings = simulation.ImuSamples();
  const simulate::ImuSimulationOptions& imu = simulation.options().imu;
  walk.calibration = {.T_BC = imu.T_BC, .noise = imu.noise, .rate = imu.rate};
  return walk;
}

}  // namespace highwall::testing
