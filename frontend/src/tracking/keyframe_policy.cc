#include <highwall/frontend/tracking/keyframe_policy.h>

#include <algorithm>

#include <highwall/core/error.h>

namespace highwall {

void KeyFramePolicyOptions::Validate() const {
  HIGHWALL_REQUIRE(min_features >= 6, "KeyFramePolicyOptions::min_features must be at least 6");
  HIGHWALL_REQUIRE(min_share > 0.0 && min_share <= 1.0,
                   "KeyFramePolicyOptions::min_share must be in (0, 1]");
  HIGHWALL_REQUIRE(max_gap >= 1, "KeyFramePolicyOptions::max_gap must be at least 1");
  HIGHWALL_REQUIRE(wanted_tracked >= 0 && wanted_new >= 0,
                   "KeyFramePolicyOptions::wanted_tracked and wanted_new must not be negative");
}

KeyFramePolicy::KeyFramePolicy(const KeyFramePolicyOptions& options) : options_(options) {
  options_.Validate();
}

bool KeyFramePolicy::CanStart(const FrameFeatures& features) const {
  const auto points =
      std::count_if(features.points.begin(), features.points.end(),
                    [](const PointFeature& feature) { return feature.depth > 0.0; });
  const auto lines =
      std::count_if(features.lines.begin(), features.lines.end(),
                    [](const LineFeature& feature) { return feature.segment_C.has_value(); });
  return points + 4 * lines >= options_.min_features;
}

bool KeyFramePolicy::Wants(const TrackedFrame& tracked, const Map& map,
                           std::int64_t last_keyframe_index) const {
  if (tracked.frame.index - last_keyframe_index >= options_.max_gap) return true;

  int with_depth = 0, waiting = 0;
  for (std::size_t i = 0; i < tracked.points.size(); ++i) {
    if (tracked.frame.features->points[i].depth <= 0.0) continue;
    ++(tracked.points[i] != kNoId ? with_depth : waiting);
  }
  if (with_depth < options_.wanted_tracked && waiting > options_.wanted_new) return true;

  // Landmarks that only the reference itself has seen are on probation and do not count.
  const KeyFrame& reference = *map.keyframe(tracked.reference);
  const int enough = map.num_keyframes() > 2 ? 2 : 1;
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
