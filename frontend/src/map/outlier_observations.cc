#include <highwall/frontend/map/outlier_observations.h>

namespace highwall {

void Forget(const OutlierObservations& outliers, Map* map) {
  for (const auto& [keyframe, point] : outliers.points) {
    map->ForgetPointObservation(keyframe, point);
  }
  for (const auto& [keyframe, line] : outliers.lines) map->ForgetLineObservation(keyframe, line);
}

}  // namespace highwall
