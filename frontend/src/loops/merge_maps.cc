#include <highwall/core/error.h>
#include <highwall/frontend/local/bundle_adjustment.h>
#include <highwall/frontend/local/global_adjustment.h>
#include <highwall/frontend/loops/merge_maps.h>
#include <highwall/frontend/map/feature_type_mismatch.h>
#include <highwall/frontend/map/measurement_model.h>

#include <algorithm>
#include <set>
#include <utility>

#include "loops/loop_closer.h"
#include "map/add_map.h"

namespace highwall {
namespace {

// Adjusts everything when submaps have merged and at the end, not after every loop: the keyframes
// of a whole session follow, and most of them close one.
LoopCloserOptions WithoutAdjustment(LoopCloserOptions options) {
  options.enabled = true;
  options.adjust = false;
  return options;
}

void RequireOneKind(const std::vector<Map>& maps) {
  const Map* first = nullptr;
  for (const Map& map : maps) {
    if (map.num_keyframes() == 0) continue;
    if (first == nullptr) first = &map;
    if (const auto clash = FindMismatch(*first, map)) {
      throw InvalidArgument("MergeMaps: the points of one map are by " + clash->first +
                            ", those of another by " + clash->second);
    }
  }
}

// Puts the maps into one, unconnected; the first one even keeps its ids, including gaps.
MergedMaps Collect(std::vector<Map> maps) {
  MergedMaps merged;
  for (Map& map : maps) {
    if (map.num_keyframes() == 0) {
      merged.keyframes.emplace_back();
    } else if (merged.map.num_keyframes() == 0) {
      merged.keyframes.push_back(map.keyframe_ids());
      merged.map = std::move(map);
      // As for all added maps: the motion of the body is not part of the camera's model.
      for (const KeyFrameId id : merged.keyframes.back()) merged.map.keyframe(id)->motion.reset();
    } else {
      merged.keyframes.push_back(AddMap(map, &merged.map));
      map = Map();  // as large as what was added
    }
  }
  return merged;
}

class MapMerger {
 public:
  MapMerger(const MeasurementModel& model, const LoopCloserOptions& options, MergedMaps& merged)
      : model_(model),
        options_(options),
        closer_(model, WithoutAdjustment(options), 0),
        merged_(merged) {}

  // Looks for a keyframe among older ones.
  void Search(KeyFrameId keyframe) {
    closer_.InsertKeyFrame(merged_.map, keyframe);
    for (LoopReport& refused : closer_.TakeRefused()) merged_.loops.push_back(std::move(refused));
    for (LoopReport& report : closer_.Finish(&merged_.map)) {
      const SubmapId world = *merged_.map.RootOf(keyframe);
      if (report.accepted) changed_.insert(world);
      const bool met = report.accepted && report.merge.has_value();
      merged_.loops.push_back(std::move(report));
      if (met) Adjust(world);
    }
  }

  void AdjustWhatChanged() {
    std::set<SubmapId> worlds;
    for (const SubmapId submap : changed_) worlds.insert(merged_.map.Root(submap));
    for (const SubmapId world : worlds) Adjust(world);
  }

 private:
  // A failed solve leaves everything unchanged.
  void Adjust(SubmapId world) {
    if (!options_.adjust) return;
    AdjustBundle(merged_.map, model_, merged_.map.KeyFramesOf(world), {}, kGlobalAdjustment);
  }

  const MeasurementModel& model_;
  const LoopCloserOptions options_;
  LoopCloser closer_;
  MergedMaps& merged_;
  std::set<SubmapId> changed_;
};

}  // namespace

void MergeMapsOptions::Validate() const {
  measurement.Validate();
  loops.Validate();
}

MergedMaps MergeMaps(const RgbdSensor& sensor, std::vector<Map> maps,
                     const MergeMapsOptions& options, const MergeProgress& progress) {
  options.Validate();
  RequireOneKind(maps);
  MergedMaps merged = Collect(std::move(maps));
  const MeasurementModel model(sensor, options.measurement, Pose(),
                               merged.map.feature_type().pyramid);
  std::vector<KeyFrameId> later;
  const auto first =
      std::ranges::find_if(merged.keyframes, [](const auto& m) { return !m.empty(); });
  if (first == merged.keyframes.end()) return merged;
  for (auto of_map = std::next(first); of_map != merged.keyframes.end(); ++of_map) {
    later.insert(later.end(), of_map->begin(), of_map->end());
  }
  MapMerger merger(model, options.loops, merged);
  for (std::size_t i = 0; i < later.size(); ++i) {
    merger.Search(later[i]);
    if (progress) progress(i + 1, later.size());
  }
  merger.AdjustWhatChanged();
  return merged;
}

}  // namespace highwall
