#include "map/map_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <highwall/frontend/features/line_matcher.h>

namespace highwall {
namespace {

// Matches the descriptors of projected points.
LandmarkMatches<MapPoint> Matched(const MeasurementModel& model, const FrameFeatures& features,
                                  const std::vector<ProjectedPoint>& projections,
                                  const std::vector<bool>& taken, double ratio) {
  const auto found = MatchProjections(features, projections, taken,
                                      {.max_hamming = model.options().max_hamming.projection,
                                       .ratio = ratio,
                                       .max_angle_diff = model.matching().max_angle_diff});
  LandmarkMatches<MapPoint> matches;
  matches.reserve(found.size());
  for (const auto& m : found) {
    matches.emplace_back(m.feature, projections[static_cast<std::size_t>(m.projection)].id);
  }
  return matches;
}

}  // namespace

int MapMatcher::PredictOctave(const MapPoint& point, double distance) const {
  const double octave = std::log(point.max_distance / distance) / log_scale_factor_;
  return std::clamp(static_cast<int>(std::lround(octave)), 0, model_.pyramid().levels - 1);
}

LandmarkMatches<MapPoint> MapMatcher::MatchLast(const FrameFeatures& features, const Pose& T_WC,
                                                const Map& map, const FrameFeatures& last,
                                                std::span<const PointId> last_points,
                                                double radius_scale) const {
  const Pose T_CW = T_WC.Inverse();
  std::vector<ProjectedPoint> projections;
  projections.reserve(last_points.size());
  for (std::size_t i = 0; i < last_points.size(); ++i) {
    const MapPoint* point = map.Find(last_points[i]);
    if (point == nullptr) continue;
    const Eigen::Vector3d p_C = T_CW * point->p_W;
    if (p_C.z() < model_.projection().min_depth()) continue;
    const Eigen::Vector2d uv = model_.camera().Project(p_C);
    if (!model_.Sees(uv)) continue;
    const PointFeature& seen = last.points[i];
    projections.push_back(
        {.id = point->id,
         .uv = uv,
         .depth = p_C.z(),
         .radius = model_.options().motion_radius * radius_scale * model_.Scale(seen.octave) *
                   model_.Stretch(uv),
         .min_octave = std::max(0, seen.octave - 1),
         .max_octave = std::min(model_.pyramid().levels - 1, seen.octave + 1),
         .angle = seen.angle >= 0.0F ? std::optional(seen.angle) : std::nullopt,
         .descriptor = DescriptorRow(last.point_descriptors, static_cast<int>(i))});
  }
  const std::vector<bool> none_taken(features.points.size(), false);
  return Matched(model_, features, projections, none_taken, matching().motion_ratio);
}

LandmarkMatches<MapPoint> MapMatcher::Match(const FrameFeatures& features, const Pose& T_WC,
                                            const Map& map, std::span<const PointId> points,
                                            const std::vector<bool>& taken,
                                            std::vector<PointId>* visible) const {
  const Pose T_CW = T_WC.Inverse();
  const Eigen::Matrix3d R_CW = T_CW.R();
  std::vector<ProjectedPoint> projections;
  projections.reserve(points.size());
  if (visible != nullptr) visible->reserve(visible->size() + points.size());
  for (const PointId id : points) {
    const MapPoint* point = map.Find(id);
    if (point == nullptr) continue;
    const Eigen::Vector3d p_C = R_CW * point->p_W + T_CW.p();
    if (p_C.z() < model_.projection().min_depth()) continue;
    const Eigen::Vector2d uv = model_.camera().Project(p_C);
    if (!model_.Sees(uv)) continue;
    const double distance = p_C.norm();
    // The pyramid covers the range; one more level on either side still matches.
    const double slack = model_.pyramid().scale_factor;
    if (distance < point->min_distance / slack || distance > point->max_distance * slack) continue;
    const double cosine = (point->p_W - T_WC.p()).dot(point->normal_W) / distance;
    if (cosine < matching().min_view_cosine) continue;
    const int octave = PredictOctave(*point, distance);
    // At a similar viewing angle a point lies nearer to its prediction than in an oblique view.
    const double radius = matching().map_radius * (cosine > 0.998 ? 0.625 : 1.0);
    projections.push_back({.id = id,
                           .uv = uv,
                           .depth = p_C.z(),
                           .radius = radius * model_.Scale(octave) * model_.Stretch(uv),
                           .min_octave = std::max(0, octave - 1),
                           .max_octave = std::min(model_.pyramid().levels - 1, octave + 1),
                           .angle = std::nullopt,
                           .descriptor = point->descriptor});
    if (visible != nullptr) visible->push_back(id);
  }
  return Matched(model_, features, projections, taken, matching().map_ratio);
}

LandmarkMatches<MapLine> MapMatcher::Match(const FrameFeatures& features, const Pose& T_WC,
                                           const Map& map, std::span<const LineId> lines,
                                           const std::vector<bool>& taken,
                                           std::vector<LineId>* visible) const {
  const Pose T_CW = T_WC.Inverse();
  LineFeatures predicted, observed;
  std::vector<LineId> predicted_ids;
  predicted.segments.reserve(lines.size());
  predicted_ids.reserve(lines.size());
  if (visible != nullptr) visible->reserve(visible->size() + lines.size());
  for (const LineId id : lines) {
    const MapLine* line = map.Find(id);
    if (line == nullptr) continue;
    const auto segment = ProjectSegment(T_CW * line->segment_W, model_.camera());
    if (!segment || segment->Length() < matching().min_line_pixels) continue;
    predicted.segments.push_back(*segment);
    predicted_ids.push_back(id);
    if (visible != nullptr) visible->push_back(id);
  }
  std::vector<int> observed_features;
  observed.segments.reserve(features.lines.size());
  observed_features.reserve(features.lines.size());
  for (std::size_t i = 0; i < features.lines.size(); ++i) {
    if (taken[i]) continue;
    observed.segments.push_back(features.lines[i].segment);
    observed_features.push_back(static_cast<int>(i));
  }
  if (predicted.segments.empty() || observed.segments.empty()) return {};
  if (!features.line_descriptors.empty()) {
    const cv::Mat& all = features.line_descriptors;
    predicted.descriptors.create(static_cast<int>(predicted_ids.size()), 32, CV_8U);
    for (int i = 0; i < predicted.descriptors.rows; ++i) {
      const BinaryDescriptor256& d =
          map.Find(predicted_ids[static_cast<std::size_t>(i)])->descriptor;
      std::ranges::copy(d, predicted.descriptors.ptr(i));
    }
    observed.descriptors.create(static_cast<int>(observed_features.size()), all.cols, all.type());
    for (int i = 0; i < observed.descriptors.rows; ++i) {
      const std::uint8_t* const row = all.ptr(observed_features[static_cast<std::size_t>(i)]);
      std::copy_n(row, static_cast<std::size_t>(all.cols) * all.elemSize(),
                  observed.descriptors.ptr(i));
    }
  }
  LandmarkMatches<MapLine> matches;
  for (const FeatureMatch& m : MatchSmallMotion(predicted, observed, matching().lines)) {
    matches.emplace_back(observed_features[static_cast<std::size_t>(m.train)],
                         predicted_ids[static_cast<std::size_t>(m.query)]);
  }
  return matches;
}

}  // namespace highwall
