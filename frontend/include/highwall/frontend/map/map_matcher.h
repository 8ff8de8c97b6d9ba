#pragma once

#include <span>
#include <utility>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/map/projection_matcher.h>

namespace highwall {

struct MapMatcherOptions {
  double motion_radius = 15.0;  // [px] > 0: search window around the landmarks of the last frame
  double map_radius = 4.0;      // [px] > 0: around those of the local map; both grow with the level
  double min_view_cosine = 0.5;  // [-1, 1]: against the mean direction the point was seen from
  ProjectionMatchOptions motion_match{.max_hamming = 100, .ratio = 0.9};
  ProjectionMatchOptions map_match{.max_hamming = 100, .ratio = 0.8};
  float min_line_pixels = 15.0F;  // [px] >= 1: shorter projections are not looked for

  void Validate() const;
};

// Feature -> landmark.
using PointMatches = std::vector<std::pair<int, PointId>>;
using LineMatches = std::vector<std::pair<int, LineId>>;

// Finds landmarks of the map among the features of an image whose pose is roughly known.
class MapMatcher {
 public:
  MapMatcher(const MeasurementModel& model, int levels, const MapMatcherOptions& options);

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
  // the MAD of their rotations (METHOD section 1).
  LineMatches MatchLines(const FrameFeatures& features, const Pose& T_WC, const Map& map,
                         std::span<const LineId> lines, const std::vector<bool>& taken,
                         std::vector<LineId>* visible = nullptr) const;

  // The pyramid level at which a point would be seen from `distance` [m].
  int PredictOctave(const MapPoint& point, double distance) const;

 private:
  const MeasurementModel& model_;
  int levels_;
  MapMatcherOptions options_;
};

}  // namespace highwall
