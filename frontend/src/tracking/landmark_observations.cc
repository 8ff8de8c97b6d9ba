#include "tracking/landmark_observations.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "pose/support.h"

namespace highwall {
namespace {

template <class LandmarkId>
void AppendMatched(const std::vector<LandmarkId>& landmarks, std::vector<LandmarkId>* all) {
  std::copy_if(landmarks.begin(), landmarks.end(), std::back_inserter(*all),
               [](LandmarkId id) { return id != kNoId; });
}

template <class LandmarkId>
int NumMatched(const std::vector<LandmarkId>& landmarks) {
  return static_cast<int>(
      std::count_if(landmarks.begin(), landmarks.end(), [](LandmarkId id) { return id != kNoId; }));
}

}  // namespace

int MatchedSupport(const std::vector<PointId>& points, const std::vector<LineId>& lines) {
  return Support(NumMatched(points), NumMatched(lines));
}

TrackedFrame Unmatched(const Frame& frame, const Pose& T_WC) {
  TrackedFrame tracked;
  tracked.frame = frame;
  tracked.T_WC = T_WC;
  tracked.points.assign(frame.features->points.size(), kNoId);
  tracked.lines.assign(frame.features->lines.size(), kNoId);
  return tracked;
}

LandmarkObservations LandmarksSeen(const MeasurementModel& model, const Map& map,
                                   TrackedFrame& tracked) {
  const FrameFeatures& features = *tracked.frame.features;
  LandmarkObservations seen;
  for (std::size_t i = 0; i < tracked.points.size(); ++i) {
    const MapPoint* point = map.Find(tracked.points[i]);
    if (point == nullptr) {
      tracked.points[i] = kNoId;
      continue;
    }
    seen.points.push_back(MakePosePoint(model, *point, features.points[i]));
    seen.point_features.push_back(i);
  }
  for (std::size_t i = 0; i < tracked.lines.size(); ++i) {
    const MapLine* line = map.Find(tracked.lines[i]);
    std::optional<PoseLine> pose_line;
    if (line != nullptr) pose_line = MakePoseLine(model, *line, features.lines[i], tracked.T_WC);
    if (!pose_line) {
      tracked.lines[i] = kNoId;
      continue;
    }
    seen.lines.push_back(*pose_line);
    seen.line_features.push_back(i);
  }
  return seen;
}

void TakePose(const LandmarkObservations& seen, const PoseSolution& solution,
              const DegeneracyOptions& degeneracy, TrackedFrame* tracked) {
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    if (!solution.point_inliers[i]) tracked->points[seen.point_features[i]] = kNoId;
  }
  for (std::size_t i = 0; i < seen.lines.size(); ++i) {
    if (!solution.line_inliers[i]) tracked->lines[seen.line_features[i]] = kNoId;
  }
  tracked->T_WC = solution.T_WC;
  tracked->num_points = solution.num_points;
  tracked->num_lines = solution.num_lines;
  tracked->num_planes = solution.num_planes;
  tracked->information = solution.information;
  tracked->gradient = solution.gradient;
  tracked->error = solution.error;
  tracked->open =
      FindUnobservableDirections(solution.information, solution.T_WC, solution.depth, degeneracy);
}

LandmarksInView MatchAround(const MapMatcher& matcher, const Map& map, int most,
                            TrackedFrame* tracked) {
  std::vector<KeyFrameId> local;
  for (const auto& [id, shared] : map.Observers(*tracked)) {
    if (static_cast<int>(local.size()) == most) break;
    local.push_back(id);
  }
  const FrameFeatures& features = *tracked->frame.features;
  const auto points = map.SeenBy<MapPoint>(local, tracked->points);
  const auto lines = map.SeenBy<MapLine>(local, tracked->lines);
  const std::vector<PointId> first_points = tracked->points;
  const std::vector<LineId> first_lines = tracked->lines;
  LandmarksInView in_view;
  Apply(
      matcher.Match(features, tracked->T_WC, map, points, Taken(tracked->points), &in_view.points),
      tracked->points);
  Apply(matcher.Match(features, tracked->T_WC, map, lines, Taken(tracked->lines), &in_view.lines),
        tracked->lines);
  AppendMatched(first_points, &in_view.points);
  AppendMatched(first_lines, &in_view.lines);
  return in_view;
}

void LandmarkCounts::AddTo(Map* map) const {
  for (const PointId id : in_view.points) {
    if (MapPoint* point = map->Find(id)) ++point->visible;
  }
  for (const LineId id : in_view.lines) {
    if (MapLine* line = map->Find(id)) ++line->visible;
  }
  for (const PointId id : found_points) {
    if (MapPoint* point = map->Find(id)) ++point->found;
  }
  for (const LineId id : found_lines) {
    if (MapLine* line = map->Find(id)) ++line->found;
  }
}

}  // namespace highwall
