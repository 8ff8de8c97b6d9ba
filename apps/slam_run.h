#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/dataset.h>
#include <highwall/frontend/slam_system.h>

#include "dense_map.h"

namespace highwall::apps {

struct SlamRunOptions {
  SlamOptions slam;
  bool dense = true;  // build cloud, octree and grid
  DenseMapOptions map;
  std::size_t begin = 0, end = SIZE_MAX;  // frames of the dataset
  std::size_t prefetch = 4;               // frames decoded ahead
};

// Mean, median and 95th percentile of samples [ms]; zeros for none.
struct Milliseconds {
  double mean = 0.0, median = 0.0, p95 = 0.0;
  std::size_t count = 0;
};
Milliseconds Summarize(std::vector<double> samples);

struct StageTimes {
  Milliseconds points, lines;  // extraction, side by side
  Milliseconds features;       // both
  Milliseconds pose;           // matching and pose estimation
  Milliseconds tracking;       // features + pose: what a frame costs
  Milliseconds mapping;        // local mapping, per keyframe
  Milliseconds dense;          // cloud of a keyframe
};

struct SlamRun {
  Trajectory trajectory, keyframes;
  std::size_t frames = 0;   // fed
  std::size_t skipped = 0;  // unusable images
  std::vector<Stamp> lost;  // frames without a pose, those before the map began included
  std::size_t relocalizations = 0;
  std::size_t points = 0, lines = 0;                 // landmarks in the end
  std::size_t keyframes_made = 0;                    // culled ones included
  double matched_points = 0.0, matched_lines = 0.0;  // mean per tracked frame
  StageTimes times;
  double seconds = 0.0;  // of the whole run, dense map included
  std::optional<DenseMap> dense;
};

// Called after each frame with the frame, its image and how many lie behind and ahead.
using FrameCallback = std::function<void(const FrameResult& result, const RgbdImage& image,
                                         std::size_t done, std::size_t total)>;

// Feeds a dataset to SlamSystem, and the keyframes to the dense map.
SlamRun RunSlam(const Dataset& dataset, const RgbdSensor& sensor, const SlamRunOptions& options,
                const FrameCallback& on_frame = {});

// The most memory that the process has held so far [MiB].
double PeakMemoryMib();

}  // namespace highwall::apps
