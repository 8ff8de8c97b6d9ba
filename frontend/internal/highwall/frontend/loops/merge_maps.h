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
  LoopCloserOptions loops{};  // `enabled` is ignored

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Several maps merged into one. Maps that overlap share a world (Map::Root); the others remain in
// separate submaps.
struct MergedMaps {
  Map map;
  std::vector<std::vector<KeyFrameId>> keyframes;  // of each given map, in their order
  std::vector<LoopReport> loops;  // merges, loops closed and rejected, as in SlamCallbacks::on_loop
};

// Progress callback: how many of the keyframes have been searched.
using MergeProgress = std::function<void(std::size_t done, std::size_t total)>;

// Merges the maps of several sessions into one: adds them as separate submaps, then searches for
// every keyframe of the second and later ones in the older maps, as SlamSystem does for a new
// keyframe: submaps that overlap are merged, loops between them are closed, and each world that
// changed is adjusted at the end. No world moves unless it overlaps another; of two that overlap
// the older one stays in place, unless the other alone knows gravity. The same maps give the same
// result, bit for bit: all of it runs on the caller's thread.
//
// sensor: of all of them; only the camera and the noise of its depth are used. Maps without
// keyframes are skipped. Throws InvalidArgument for bad options, and if points of two maps differ
// in kind (FindMismatch).
MergedMaps MergeMaps(const RgbdSensor& sensor, std::vector<Map> maps,
                     const MergeMapsOptions& options = {}, const MergeProgress& progress = {});

}  // namespace highwall
