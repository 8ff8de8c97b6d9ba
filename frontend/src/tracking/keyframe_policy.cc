#include "tracking/keyframe_policy.h"

#include <algorithm>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>

namespace highwall {

KeyFramePolicy::KeyFramePolicy(const KeyFramePolicyOptions& options) : options_(options) {
  options_.Validate();
}

bool KeyFramePolicy::CanStart(const FrameFeatures& features) const {
  const auto points =
      std::count_if(features.points.begin(), features.points.end(),
                    [](const PointFeature& p) { return p.depth > 0.0 && !p.faint; });
  const auto lines =
      std::count_if(features.lines.begin(), features.lines.end(),
                    [](const LineFeature& feature) { return feature.segment_C.has_value(); });
  return points + 4 * lines >= options_.min_features;
}

bool KeyFramePolicy::Wants(const TrackedFrame& tracked, const Map& map, Stamp last_keyframe) const {
  if (ToSeconds(tracked.frame.stamp - last_keyframe) >= options_.max_gap) return true;
  // It shares no landmark with any other: the map goes on there only if it must.
  if (tracked.num_points + tracked.num_lines == 0) return false;

  int with_depth = 0, waiting = 0;
  for (std::size_t i = 0; i < tracked.points.size(); ++i) {
    if (tracked.frame.features->points[i].depth <= 0.0) continue;
    ++(tracked.points[i] != kNoId ? with_depth : waiting);
  }
  if (with_depth < options_.wanted_tracked && waiting > options_.wanted_new) return true;

  // Landmarks that only the reference itself has seen are on probation and do not count.
  const KeyFrame& reference = *map.keyframe(tracked.reference);
  const int enough = map.NumKeyFramesOf(tracked.submap) > 2 ? 2 : 1;
  const auto established = [&](const auto* landmark) {
    return landmark != nullptr && static_cast<int>(landmark->observations.size()) >= enough;
  };
  const auto points = std::count_if(reference.points.begin(), reference.points.end(),
                                    [&](PointId id) { return established(map.point(id)); });
  const auto lines = std::count_if(reference.lines.begin(), reference.lines.end(),
                                   [&](LineId id) { return established(map.line(id)); });
  return tracked.num_points + tracked.num_lines <
         options_.min_share * static_cast<double>(points + lines);
}

}  // namespace highwall
