#include <highwall/frontend/tracking/standard_keyframe_policy.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <highwall/internal/median.h>

namespace highwall {
namespace {

// [s] without a pose from images after which the map continues at the pose of the IMU.
constexpr double kBlind = 0.48;

// Returns whether the camera is stationary where it made the reference keyframe: half of their
// common points are where that keyframe saw them, within twice the noise of a corner. False if
// there are too few points.
bool Stands(const KeyFrameCandidate& candidate, const KeyFrame& reference) {
  constexpr double kNoise = 2.0;  // [px]
  constexpr std::size_t kEnough = 20;
  std::vector<std::pair<PointId, std::size_t>> seen;
  seen.reserve(reference.points.size());
  for (std::size_t i = 0; i < reference.points.size(); ++i) {
    if (reference.points[i] != kNoId) seen.emplace_back(reference.points[i], i);
  }
  std::ranges::sort(seen);
  std::vector<double> shifts;
  shifts.reserve(seen.size());
  for (std::size_t i = 0; i < candidate.points.size(); ++i) {
    const auto before =
        std::ranges::lower_bound(seen, std::pair(candidate.points[i], std::size_t{0}));
    if (before == seen.end() || before->first != candidate.points[i]) continue;
    const Eigen::Vector2d& uv = reference.frame.features->points[before->second].uv;
    shifts.push_back((candidate.frame.features->points[i].uv - uv).norm());
  }
  return shifts.size() >= kEnough && UpperMedian(std::move(shifts)) < kNoise;
}

}  // namespace

StandardKeyFramePolicy::StandardKeyFramePolicy(const KeyFramePolicyOptions& options)
    : options_(options) {
  options_.Validate();
}

bool StandardKeyFramePolicy::CanStart(const FrameFeatures& features) {
  const auto points =
      std::count_if(features.points.begin(), features.points.end(),
                    [](const PointFeature& p) { return p.depth > 0.0 && !p.low_contrast; });
  const auto lines =
      std::count_if(features.lines.begin(), features.lines.end(),
                    [](const LineFeature& feature) { return feature.segment_C.has_value(); });
  return points + 4 * lines >= options_.min_features;
}

bool StandardKeyFramePolicy::Wants(const KeyFrameCandidate& candidate, const Map& map) {
  int with_depth = 0, waiting = 0;
  for (std::size_t i = 0; i < candidate.points.size(); ++i) {
    if (candidate.frame.features->points[i].depth <= 0.0) continue;
    ++(candidate.points[i] != kNoId ? with_depth : waiting);
  }
  if (candidate.since_keyframe <= since_keyframe_) unmatched_ = waiting;
  since_keyframe_ = candidate.since_keyframe;

  if (candidate.state == TrackingState::kInertial) {
    return candidate.since_image >= kBlind && CanStart(*candidate.frame.features);
  }
  const KeyFrame* const seen_from = map.keyframe(candidate.reference);
  if (candidate.since_keyframe >= options_.max_gap) {
    const bool stands =
        !candidate.with_imu && seen_from != nullptr && Stands(candidate, *seen_from);
    if (!stands) return true;
  }
  // The frame shares no landmark with a keyframe: the map continues there only if it must.
  if (candidate.num_points + candidate.num_lines == 0) return false;

  // While enough landmarks hold the frame, only points that have come into view are new: another
  // keyframe would map corners once more that are not found again.
  const bool holds = candidate.num_points + candidate.num_lines >= options_.wanted_tracked;
  const int fresh = holds ? waiting - unmatched_ : waiting;
  if (with_depth < options_.wanted_tracked && fresh > options_.wanted_new) return true;

  // Landmarks that only the reference itself has seen are on probation and do not count.
  const KeyFrame& reference = *seen_from;
  const int enough = map.NumKeyFramesOf(candidate.submap) > 2 ? 2 : 1;
  const auto established = [&](const auto* landmark) {
    return landmark != nullptr && static_cast<int>(landmark->observations.size()) >= enough;
  };
  const auto points = std::count_if(reference.points.begin(), reference.points.end(),
                                    [&](PointId id) { return established(map.Find(id)); });
  const auto lines = std::count_if(reference.lines.begin(), reference.lines.end(),
                                   [&](LineId id) { return established(map.Find(id)); });
  return candidate.num_points + candidate.num_lines <
         options_.min_share * static_cast<double>(points + lines);
}

}  // namespace highwall
