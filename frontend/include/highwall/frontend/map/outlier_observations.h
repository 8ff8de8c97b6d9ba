#pragma once

#include <utility>
#include <vector>

#include <highwall/frontend/map/map.h>

namespace [[gnu::visibility("default")]] highwall {

// Observations of landmarks of one kind, by keyframe.
template <class Landmark>
using ObservationList = std::vector<std::pair<KeyFrameId, Id<Landmark>>>;
// Observations of landmarks classified as outliers by an adjustment.
using OutlierObservations = PerKind<ObservationList>;

// Removes the observations from their keyframes; skips those that no longer exist.
void Forget(const OutlierObservations& outliers, Map* map);

}  // namespace highwall
