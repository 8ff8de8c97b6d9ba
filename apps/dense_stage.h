#pragma once

#include <memory>
#include <string>
#include <vector>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/system/slam_system.h>

#include "slam_run.h"

namespace highwall::apps {

// The dense map of a run, where one is wanted; a run continues without one that fails. Sets the
// callbacks of the system, which must outlive it, as must the dataset.
class DenseStage {
 public:
  DenseStage(SlamSystem& slam, const Dataset& dataset, const RgbdSensor& sensor,
             const SlamRunOptions& options);
  ~DenseStage();
  DenseStage(const DenseStage&) = delete;  // the system calls it where it is
  DenseStage& operator=(const DenseStage&) = delete;

  // After each frame.
  void Follow(const FrameResult& result);
  // Call once, last: fills the dense map of each submap of the run, and what failed.
  void Finish(SlamRun* run);

 private:
  class KeyframeMapping;

  std::unique_ptr<KeyframeMapping> mapping_;  // empty where no map is wanted
  std::vector<std::string> failures_;
};

}  // namespace highwall::apps
