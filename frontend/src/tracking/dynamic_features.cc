#include "tracking/dynamic_features.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pose/landmark_motion.h"
#include "pose/support.h"
#include "tracking/landmark_observations.h"

namespace highwall {
namespace {

// Returns the submap of the landmarks it was matched with (at least one).
SubmapId SubmapOf(const TrackedFrame& tracked, const Map& map) {
  const auto seen_by = [&](const auto* landmark) {
    return map.keyframe(landmark->observations.front().keyframe)->submap;
  };
  for (const PointId id : tracked.points) {
    if (const MapPoint* point = map.Find(id)) return seen_by(point);
  }
  for (const LineId id : tracked.lines) {
    if (const MapLine* line = map.Find(id)) return seen_by(line);
  }
  return kFirstSubmap;
}

// Returns whether `is_on` holds for one of the ends or the middle of a line.
template <class IsOn>
bool Touches(const LineFeature& line, const IsOn& is_on) {
  const Eigen::Vector2d s = line.segment.s.cast<double>(), e = line.segment.e.cast<double>();
  return is_on(s) || is_on(e) || is_on(0.5 * (s + e));
}

// Returns a test of whether a pixel [px] is on a nonzero cell of the mask.
auto On(const cv::Mat& mask, const DepthGrid& grid) {
  return [&](const Eigen::Vector2d& uv) { return mask.at<std::uint8_t>(grid.CellOf(uv)) != 0; };
}

}  // namespace

DynamicFeatures::DynamicFeatures(const MeasurementModel& model, const DynamicObjectOptions& options,
                                 const DynamicObjectParameters& parameters)
    : model_(model),
      landmarks_(parameters.landmarks),
      objects_(model.camera(), model.depth_noise(), options, parameters) {}

bool DynamicFeatures::HasMoved(const TrackedFrame& rough, const Map& map,
                               const DepthSurfaces& surfaces, int surface,
                               const cv::Mat& moving) const {
  const FrameFeatures& features = *rough.frame.features;
  const auto is_on = [&](const Eigen::Vector2d& uv) {
    return surfaces.labels.at<int>(grid().CellOf(uv)) == surface;
  };
  const auto moves = On(moving, grid());
  std::vector<PosePoint> judged;
  int judged_lines = 0;
  TrackedFrame others = Unmatched(rough.frame, rough.T_WC);
  for (std::size_t i = 0; i < rough.tried_points.size(); ++i) {
    const MapPoint* point = map.Find(rough.tried_points[i]);
    if (point == nullptr) continue;
    if (is_on(features.points[i].uv)) {
      judged.push_back(MakePoseObservation(model_, *point, features.points[i]));
    } else if (!moves(features.points[i].uv)) {
      others.points[i] = point->id;
    }
  }
  if (static_cast<int>(judged.size()) < landmarks_.min_points) return false;
  for (std::size_t i = 0; i < rough.tried_lines.size(); ++i) {
    if (rough.tried_lines[i] == kNoId) continue;
    if (Touches(features.lines[i], is_on)) {
      ++judged_lines;
    } else if (!Touches(features.lines[i], moves)) {
      others.lines[i] = rough.tried_lines[i];
    }
  }
  const LandmarkObservations seen = LandmarksSeen(model_, map, others);
  return HaveMoved(rough.T_WC, model_.projection(), judged, judged_lines, seen, landmarks_);
}

cv::Mat DynamicFeatures::Find(const TrackedFrame& tracked, const Map& map) const {
  return objects_.Find(tracked.frame.stamp, tracked.frame.features->depth_grid, tracked.T_WC, map,
                       SubmapOf(tracked, map),
                       [&](const DepthSurfaces& surfaces, int surface, const cv::Mat& moving) {
                         return HasMoved(tracked, map, surfaces, surface, moving);
                       });
}

int DynamicFeatures::SupportBeside(const TrackedFrame& tracked, const cv::Mat& moving) const {
  const FrameFeatures& features = *tracked.frame.features;
  const auto moves = On(moving, grid());
  int points = 0, lines = 0;
  for (std::size_t i = 0; i < tracked.points.size(); ++i) {
    points += tracked.points[i] != kNoId && !moves(features.points[i].uv) ? 1 : 0;
  }
  for (std::size_t i = 0; i < tracked.lines.size(); ++i) {
    lines += tracked.lines[i] != kNoId && !Touches(features.lines[i], moves) ? 1 : 0;
  }
  return highwall::Support(points, lines);
}

void DynamicFeatures::MaskOut(TrackedFrame& rough) const {
  if (rough.moving.empty()) return;
  const FrameFeatures& features = *rough.frame.features;
  const cv::Mat aside = WithBorder(rough.moving);
  const auto moves = On(aside, grid());
  std::vector<bool> points, lines;
  for (const PointFeature& point : features.points) points.push_back(!moves(point.uv));
  for (const LineFeature& line : features.lines) lines.push_back(!Touches(line, moves));
  const auto keep = [](const std::vector<bool>& kept, auto& landmarks) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (kept[i]) landmarks[n++] = landmarks[i];
    }
    landmarks.resize(n);
  };
  keep(points, rough.points);
  keep(lines, rough.lines);
  const PinholeCamera& camera = model_.camera();
  rough.frame.features = Select(features, points, lines, {camera.width, camera.height});
}

}  // namespace highwall
