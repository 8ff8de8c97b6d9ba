#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/line_matcher.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_solver.h>

namespace highwall {

struct RelocalizerOptions {
  int candidates = 5;           // >= 1: keyframes verified, most alike first
  int max_hamming = 60;         // [bit] of a match
  double ratio = 0.8;           // (0, 1]: best against second best
  int min_matches = 15;         // >= 3: with a keyframe, to verify it
  int min_inliers = 20;         // >= 6: points plus twice the lines, after RANSAC and refinement
  int min_line_inliers = 8;     // >= 4: lines after refinement, where there are too few points
  int ransac_iterations = 200;  // >= 1
  std::uint32_t seed = 1;

  void Validate() const;
};

struct Relocalization {
  Pose T_WC;
  KeyFrameId keyframe = kNoId;
  // Feature -> landmark, inliers; lines alone where points were too few.
  std::vector<std::pair<int, PointId>> points;
  std::vector<std::pair<int, LineId>> lines;
};

// Pose of a frame from the keyframes alone, without a prediction: the map's index names keyframes
// that look alike, 3-D to 3-D RANSAC on the matched points, in which matched lines count,
// verifies them, SolvePose refines with both. Where points do not do it, lines matched by LBD are
// solved from a guess near the keyframe.
class Relocalizer {
 public:
  Relocalizer(const MeasurementModel& model, const RelocalizerOptions& options);

  // Empty where no keyframe is verified.
  std::optional<Relocalization> Relocalize(const FrameFeatures& features, const Map& map) const;
  // Against one keyframe (live), without the vote. guess: T_WC where lines start from.
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
