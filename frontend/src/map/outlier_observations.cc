#include <highwall/frontend/map/outlier_observations.h>

namespace highwall {

void Forget(const OutlierObservations& outliers, Map* map) {
  for (const auto& [keyframe, point] : outliers.points) {
    map->Forget(keyframe, point);
  }
  for (const auto& [keyframe, line] : outliers.lines) map->Forget(keyframe, line);
}

}  // namespace highwall
