#pragma once

#include <span>
#include <utility>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/map/options.h>

#include "map/projection_matcher.h"

namespace highwall {

// Feature -> landmark.
using PointMatches = std::vector<std::pair<int, PointId>>;
using LineMatches = std::vector<std::pair<int, LineId>>;

// Finds landmarks of the map among the features of an image whose pose is roughly known.
class MapMatcher {
 public:
  // model: must outlive the matcher; its options say how to search.
  explicit MapMatcher(const MeasurementModel& model) : model_(model) {}

  const MeasurementModel& model() const { return model_; }

  // Landmarks seen by `last` (feature -> point): the level and the orientation they had there are
  // the ones expected. radius_scale: factor on motion_radius.
  PointMatches MatchLast(const FrameFeatures& features, const Pose& T_WC, const Map& map,
                         const FrameFeatures& last, std::span<const PointId> last_points,
                         double radius_scale = 1.0) const;

  // Points of the map by their own scale range and viewing direction. taken: features not to use.
  // visible: gets the points in view, matched or not.
  PointMatches MatchPoints(const FrameFeatures& features, const Pose& T_WC, const Map& map,
                           std::span<const PointId> points, const std::vector<bool>& taken,
                           std::vector<PointId>* visible = nullptr) const;

  // Lines of the map by the gates on angle, length and midpoint, by LBD where both have it, and by
  // the MAD of their rotations (docs/equations.md, section 1).
  LineMatches MatchLines(const FrameFeatures& features, const Pose& T_WC, const Map& map,
                         std::span<const LineId> lines, const std::vector<bool>& taken,
                         std::vector<LineId>* visible = nullptr) const;

  // The pyramid level at which a point would be seen from `distance` [m].
  int PredictOctave(const MapPoint& point, double distance) const;

 private:
  const MapMatcherOptions& options() const { return model_.options().search; }

  const MeasurementModel& model_;
};

}  // namespace highwall
