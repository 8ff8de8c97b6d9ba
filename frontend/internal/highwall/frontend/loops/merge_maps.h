#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>
#include <highwall/frontend/map/options.h>

namespace [[gnu::visibility("default")]] highwall {

struct MergeMapsOptions {
  MeasurementOptions measurement{};
  LoopCloserOptions loops{};  // on the caller's thread; `enabled` and `background` do not count

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Several maps in one. What met shares a world (Map::Root), the others remain in submaps apart.
struct MergedMaps {
  Map map;
  std::vector<std::vector<KeyFrameId>> keyframes;  // of each map that was given, in their order
  std::vector<LoopReport> loops;  // merges, loops closed and refused, as SlamCallbacks::on_loop
};

// How many of the keyframes have been searched.
using MergeProgress = std::function<void(std::size_t done, std::size_t total)>;

// Makes one map of those of several sessions: puts them beside each other, then looks for every
// keyframe of the second and later ones in what is older, as SlamSystem does for a new keyframe:
// submaps that meet are merged, loops closed across, and each world in which anything changed is
// adjusted in the end. No world moves unless it meets another; of two that meet the older stays in
// place, unless the other alone knows gravity. The same maps give the same result, bit for bit,
// where options.loops.correction.threads and bundle.threads are 1.
//
// sensor: of all of them; only the camera and the noise of its depth count. Maps without keyframes
// are passed over. Throws InvalidArgument on bad options, and where points of two maps differ in
// kind (FindClash).
MergedMaps MergeMaps(const RgbdSensor& sensor, std::vector<Map> maps,
                     const MergeMapsOptions& options = {}, const MergeProgress& progress = {});

}  // namespace highwall
