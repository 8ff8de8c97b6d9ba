#include "tracking/landmark_observations.h"

#include <optional>

namespace highwall {

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
    const MapPoint* point = map.point(tracked.points[i]);
    if (point == nullptr) {
      tracked.points[i] = kNoId;
      continue;
    }
    seen.points.push_back(MakePosePoint(model, *point, features.points[i]));
    seen.point_features.push_back(i);
  }
  for (std::size_t i = 0; i < tracked.lines.size(); ++i) {
    const MapLine* line = map.line(tracked.lines[i]);
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

}  // namespace highwall
