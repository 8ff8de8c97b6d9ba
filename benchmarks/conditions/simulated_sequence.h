#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <highwall/frontend/input/dataset.h>
#include <simulate/camera/simulation.h>

#include "run/slam_run.h"

namespace highwall::bench {

// Frames of a simulation, rendered once and kept in memory, so that several runs use the same
// images.
class SimulatedSequence final : public Dataset {
 public:
  // Contains the frames from `begin` [s] after the first frame to the last.
  explicit SimulatedSequence(const simulate::Simulation& simulation, double begin = 0.0);

  // Creates a sequence without the first frames of another; first <= its size; the images are
  // shared.
  SimulatedSequence(const SimulatedSequence& sequence, std::size_t first);

  std::size_t size() const override { return images_.size(); }
  Stamp stamp(std::size_t index) const override { return images_[index].stamp; }
  const Trajectory* groundtruth() const override { return &truth_; }

  // Returns the camera model for an estimator.
  const RgbdSensor& sensor() const { return sensor_; }
  // Returns the readings from half a second before the first frame on.
  const apps::ImuFeed& imu() const { return imu_; }

  // Multiplies all depth by `factor`.
  void ScaleDepth(double factor);

 private:
  RgbdImage DoLoad(std::size_t index) const override { return images_.at(index); }

  RgbdSensor sensor_;
  apps::ImuFeed imu_;
  std::vector<RgbdImage> images_;
  Trajectory truth_;
};

}  // namespace highwall::bench
