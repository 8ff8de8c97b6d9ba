#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <highwall/frontend/input/dataset.h>
#include <simulate/camera/simulation.h>

#include "slam_run.h"

namespace highwall::bench {

// Frames of a simulation, rendered once and kept in memory, so that several runs see the same.
class SimulatedSequence final : public Dataset {
 public:
  // From `begin` [s] after the first frame to the last.
  explicit SimulatedSequence(const simulate::Simulation& simulation, double begin = 0.0);

  // Another without its first frames; first <= its size; the images are shared.
  SimulatedSequence(const SimulatedSequence& sequence, std::size_t first);

  std::size_t size() const override { return images_.size(); }
  Stamp stamp(std::size_t index) const override { return images_[index].stamp; }
  const Trajectory* groundtruth() const override { return &truth_; }

  // What an estimator should take the camera for.
  const RgbdSensor& sensor() const { return sensor_; }
  // The readings from half a second before the first frame on.
  const apps::ImuFeed& imu() const { return imu_; }

  // All depth so many times as long.
  void ScaleDepth(double factor);

 private:
  RgbdImage DoLoad(std::size_t index) const override { return images_.at(index); }

  RgbdSensor sensor_;
  apps::ImuFeed imu_;
  std::vector<RgbdImage> images_;
  Trajectory truth_;
};

}  // namespace highwall::bench
