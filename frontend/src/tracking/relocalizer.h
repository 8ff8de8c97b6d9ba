#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/line_matcher.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

// Criteria by which Relocalizer verifies a keyframe.
struct RelocalizerOptions {
  int min_matches = 15;         // >= 3: with a keyframe, to verify it
  int min_inliers = 20;         // >= 6: points plus twice the lines, after RANSAC and refinement
  int min_line_inliers = 8;     // >= 4: lines after refinement, where there are too few points
  int ransac_iterations = 200;  // >= 1
};

struct Relocalization {
  Pose T_WC;
  KeyFrameId keyframe = kNoId;
  // Feature -> landmark, inliers; lines alone where points were too few.
  PerKind<LandmarkMatches> matches;
};

// Estimates the pose of a frame from the keyframes alone, without a prediction: the map's index
// returns similar keyframes, 3-D to 3-D RANSAC on the matched points, with matched lines in the
// consensus, verifies them, and SolvePose refines with both. If points do not suffice, lines
// matched by LBD are solved from an initial guess near the keyframe.
class Relocalizer {
 public:
  Relocalizer(const MeasurementModel& model, const RelocalizerOptions& options);

  // Returns empty if no keyframe is verified.
  std::optional<Relocalization> Relocalize(const FrameFeatures& features, const Map& map) const;
  // Matches one (active) keyframe, without the index. guess: initial T_WC for lines.
  std::optional<Relocalization> MatchKeyFrame(const FrameFeatures& features, const Map& map,
                                              KeyFrameId keyframe, const Pose& guess) const;

 private:
  std::optional<Relocalization> MatchPoints(const FrameFeatures& features, const Map& map,
                                            const KeyFrame& keyframe) const;
  std::optional<Relocalization> MatchLines(const FrameFeatures& features, const Map& map,
                                           const KeyFrame& keyframe, const Pose& guess) const;

  const MeasurementModel& model_;
  RelocalizerOptions options_;
};

}  // namespace highwall
