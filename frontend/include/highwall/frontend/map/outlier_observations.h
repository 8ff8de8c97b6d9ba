#pragma once

#include <utility>
#include <vector>

#include <highwall/frontend/map/map.h>

namespace [[gnu::visibility("default")]] highwall {

// Observations of landmarks classified as outliers by an adjustment.
struct OutlierObservations {
  std::vector<std::pair<KeyFrameId, PointId>> points;
  std::vector<std::pair<KeyFrameId, LineId>> lines;
};

// Removes the observations from their keyframes; skips those that no longer exist.
void Forget(const OutlierObservations& outliers, Map* map);

}  // namespace highwall
