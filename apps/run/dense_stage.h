#pragma once

#include <memory>
#include <string>
#include <vector>

#include <highwall/core/memory_share.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/system/slam_system.h>

#include "run/slam_run.h"

namespace highwall::apps {

// Builds the dense map of a run if it is enabled; the run continues if mapping fails. The dataset
// must outlive this object.
class DenseStage {
 public:
  // profile: of the run; must outlive this object.
  DenseStage(const SlamSystem& slam, const Dataset& dataset, const RgbdSensor& sensor,
             const SlamRunOptions& options, RunProfile* profile);
  ~DenseStage();
  DenseStage(const DenseStage&) = delete;  // callbacks of the system capture `this`
  DenseStage& operator=(const DenseStage&) = delete;

  // Sets the callbacks that it needs.
  void AddTo(SlamCallbacks* callbacks);

  // Call once, after SlamSystem::Finish(): maps what the system still holds. It is not used any
  // more afterwards, and its memory is free for the map.
  void Complete();
  // What the dense map holds in memory.
  std::vector<MemoryShare> memory();
  // Call once, last: stores the dense map of each submap in the run, together with any failures.
  void Finish(SlamRun* run);

 private:
  class KeyframeMapping;

  void Apply(const KeyframeEvent& event);

  std::unique_ptr<KeyframeMapping> mapping_;  // empty if no map is requested
  std::vector<std::string> failures_;
};

}  // namespace highwall::apps
