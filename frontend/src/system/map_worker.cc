#include "system/map_worker.h"

#include <algorithm>
#include <utility>

namespace highwall {

MapWorker::MapWorker(LocalMapper& local, std::vector<MapStage*> worlds)
    : local_(local), worlds_(std::move(worlds)) {}

bool MapWorker::IsFree() const {
  return std::ranges::all_of(worlds_, [](const MapStage* stage) { return stage->IsIdle(); });
}

void MapWorker::Preempt(const MapStage& by) {
  for (MapStage* stage : worlds_) {
    if (stage != &by) stage->Drop();
  }
}

void MapWorker::Drop(const Map& map, SubmapId submap) {
  const SubmapId root = map.Root(submap);
  const auto drop = [&](MapStage& stage) {
    stage.Forget();
    const SubmapId busy_in = stage.submap();
    if (busy_in != kNoId && map.Root(busy_in) == root) stage.Drop();
  };
  drop(local_);
  for (MapStage* stage : worlds_) drop(*stage);
}

}  // namespace highwall
