#pragma once

#include <optional>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/map_report.h>

#include "local/local_mapper.h"
#include "map/map_stage.h"

namespace highwall {

// The order in which the stages that compute on copies of the map edit it. Local adjustment moves a
// few keyframes against their neighbours; the other stages move a whole world, each from a copy of
// its own, so that only one of them works at a time:
//
// - A stage begins to work on a world when none does (IsFree). A loop does not wait: the others'
//   work is discarded (Preempt), and they begin again on the corrected map.
// - Before a world is edited, the local adjustment in progress is completed (Edit): it would
//   otherwise restore former positions of its keyframes.
// - A change by none of the stages (alignment with gravity, removal of a submap) discards all work
//   on that world (Drop).
class MapWorker {
 public:
  // All of them must outlive the worker. worlds: the stages that move a whole world.
  MapWorker(LocalMapper& local, std::vector<MapStage*> worlds);

  // Returns whether no stage works on a world or has a result to be applied.
  bool IsFree() const;
  // Discards the work of the other stages on worlds.
  void Preempt(const MapStage& by);
  // Discards the work on the world of the submap, which is changed by none of the stages; all
  // stages drop their stored positions.
  void Drop(const Map& map, SubmapId submap);

  // Completes the local adjustment in progress, then calls edit(). Returns the report of the
  // former, if there was one.
  template <class EditWorld>
  std::optional<BundleAdjustmentReport> Edit(Map* map, const EditWorld& edit) {
    auto report = local_.Finish(map);
    edit();
    return report;
  }

 private:
  LocalMapper& local_;
  const std::vector<MapStage*> worlds_;
};

}  // namespace highwall
