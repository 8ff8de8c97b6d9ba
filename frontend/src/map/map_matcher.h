#pragma once

#include <cmath>
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

// Matches landmarks of the map to the features of an image whose pose is roughly known.
class MapMatcher {
 public:
  // model: must outlive the matcher; its options define the search.
  explicit MapMatcher(const MeasurementModel& model)
      : model_(model), log_scale_factor_(std::log(model.pyramid().scale_factor)) {}

  const MeasurementModel& model() const { return model_; }

  // Matches the landmarks observed by `last` (feature -> point), expecting the level and the
  // orientation observed there. radius_scale: factor on motion_radius.
  LandmarkMatches<MapPoint> MatchLast(const FrameFeatures& features, const Pose& T_WC,
                                      const Map& map, const FrameFeatures& last,
                                      std::span<const PointId> last_points,
                                      double radius_scale = 1.0) const;

  // Matches points of the map by their scale range and viewing direction. taken: features not to
  // use. visible: receives the points in view, matched or not.
  LandmarkMatches<MapPoint> Match(const FrameFeatures& features, const Pose& T_WC, const Map& map,
                                  std::span<const PointId> points, const std::vector<bool>& taken,
                                  std::vector<PointId>* visible = nullptr) const;

  // Matches lines of the map by the gates on angle, length and midpoint, by LBD if both have it,
  // and by the MAD of their rotations (docs/equations.md, section 1).
  LandmarkMatches<MapLine> Match(const FrameFeatures& features, const Pose& T_WC, const Map& map,
                                 std::span<const LineId> lines, const std::vector<bool>& taken,
                                 std::vector<LineId>* visible = nullptr) const;

  // Returns the pyramid level at which a point is expected from `distance` [m].
  int PredictOctave(const MapPoint& point, double distance) const;

 private:
  const MatchingOptions& matching() const { return model_.matching(); }

  const MeasurementModel& model_;
  const double log_scale_factor_;
};

}  // namespace highwall
