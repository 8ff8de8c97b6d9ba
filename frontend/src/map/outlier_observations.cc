#include <highwall/frontend/map/outlier_observations.h>

namespace highwall {

void Forget(const OutlierObservations& outliers, Map* map) {
  ForEachKind([&]<class Landmark>() {
    for (const auto& [keyframe, id] : PartOf<Landmark>(outliers)) map->Forget(keyframe, id);
  });
}

}  // namespace highwall
