#include "tracking/lost_frames.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include <highwall/internal/stage_timer.h>

#include "features/corrected_depth.h"
#include "features/memory_bytes.h"
#include "map/covisibility.h"
#include "pose/depth_agreement.h"
#include "pose/support.h"
#include "sensor/feature_noise.h"
#include "tracking/constant_velocity.h"
#include "tracking/landmark_observations.h"
#include "tracking/tracker_state.h"

namespace highwall {
namespace {

// Multiple of the search window: an interpolated pose is less certain than a predicted one.
constexpr double kWide = 2.0;
constexpr int kAroundReference = 2;  // keyframes beside the reference of a frame before or after
constexpr double kReach = 1.0;       // [s] After this time a camera may have come anywhere.

}  // namespace

LostFrames::LostFrames(const MeasurementModel& model, const PinholeCamera& camera,
                       const TrackerOptions& options, std::size_t most,
                       const TrackerParameters& parameters, RunProfile* profile)
    : model_(model),
      camera_(camera),
      options_(options),
      most_(most),
      parameters_(parameters),
      profile_(profile),
      matcher_(model),
      relocalizer_(model, parameters.relocalizer),
      reference_matcher_(model, parameters.reference),
      grid_(model.camera()) {}

void LostFrames::Add(LostFrame lost) {
  if (!lost.frame.features || lost.frame.features->points.empty()) return;
  lost.frame.features = WithoutImages(*lost.frame.features);
  lost_.push_back(std::move(lost));
  if (lost_.size() > most_) lost_.erase(lost_.begin());
}

std::size_t LostFrames::MemoryBytes() const {
  std::size_t bytes = 0;
  for (const LostFrame& lost : lost_) bytes += BytesOf(*lost.frame.features);
  return bytes;
}

std::vector<PosedFrame> LostFrames::Find(const Map& map, const ImageKnowledge& knowledge,
                                         std::span<const PosedFrame> frames,
                                         double usual_match_ratio) {
  const StageTimer timer(profile_, "search for lost frames");
  std::vector<LostFrame> lost = std::exchange(lost_, {});
  std::ranges::stable_sort(lost, {}, &LostFrame::stamp);
  std::vector<PosedFrame> found;
  for (LostFrame& one : lost) {
    if (one.usual_match_ratio == 0.0) one.usual_match_ratio = usual_match_ratio;
    Neighbours around = Around(map, frames, one.frame.stamp);
    // A frame that was just found may be nearer than those that were tracked.
    if (!found.empty()) {
      const Neighbours nearer = Around(map, found, one.frame.stamp);
      if (!around.before || (nearer.before && nearer.before->stamp > around.before->stamp)) {
        around.before = nearer.before;
      }
    }
    if (auto posed = FindOne(map, knowledge, around, std::move(one))) {
      found.push_back(*std::move(posed));
    }
  }
  return found;
}

LostFrames::Neighbours LostFrames::Around(const Map& map, std::span<const PosedFrame> frames,
                                          Stamp stamp) {
  const auto is_predicted = [](const PosedFrame& frame) {
    return frame.information && frame.information->isZero(0.0F);
  };
  const auto neighbour = [&](const PosedFrame& frame) -> std::optional<Neighbour> {
    const KeyFrameId reference = frame.measured().reference;
    const auto active = map.ActiveKeyFrameOf(reference);
    if (!active) return std::nullopt;
    return Neighbour{frame.measured_at(), frame.measured().T_WC(map), active->first,
                     *map.RootOf(reference)};
  };
  const auto at = std::ranges::lower_bound(frames, stamp, {}, &PosedFrame::stamp);
  const auto after = std::find_if(at, frames.end(), [&](const PosedFrame& frame) {
    return !is_predicted(frame) && frame.measured_at() > stamp;
  });
  const auto before = std::find_if(
      std::reverse_iterator(at), frames.rend(),
      [&](const PosedFrame& frame) { return !is_predicted(frame) && frame.measured_at() < stamp; });
  Neighbours around;
  if (before != frames.rend()) around.before = neighbour(*before);
  if (after != frames.end()) around.after = neighbour(*after);
  return around;
}

std::optional<Twist> LostFrames::Neighbours::Motion() const {
  if (!before || !after || before->root != after->root) return std::nullopt;
  const double dt = ToSeconds(after->stamp - before->stamp);
  if (!(dt > 0.0 && dt <= ConstantVelocity::kLongestPrediction)) return std::nullopt;
  return Twist::Between(before->T_WC.Inverse() * after->T_WC, dt);
}

std::optional<PosedFrame> LostFrames::FindOne(const Map& map, const ImageKnowledge& knowledge,
                                              const Neighbours& around, LostFrame lost) const {
  if (knowledge.noise) {
    lost.frame.features = WithNoise(*lost.frame.features, *knowledge.noise, model_);
  }
  DepthPattern more = knowledge.pattern;
  more.nodes -= lost.pattern.nodes;
  if (!more.IsZero()) lost.frame.features = CorrectedDepth(*lost.frame.features, camera_, more);
  const std::optional<Twist> motion = around.Motion();
  if (knowledge.timing && motion) {
    RowMotion now{*knowledge.timing, *motion};
    now.timing.depth_delay += lost.frame.depth_delay;
    lost.frame.features =
        MovedOtherwise(*lost.frame.features, model_.camera(), grid_, lost.moved_by, now);
  }
  const std::optional<TrackedFrame> found = Search(map, around, lost);
  if (!found) return std::nullopt;
  PosedFrame posed{lost.stamp, AnchoredPose::At(map, found->reference, found->T_WC),
                   InformationInCamera(found->information, found->T_WC)};
  posed.delay = lost.stamp - lost.frame.stamp;
  if (posed.delay > 0) {  // its pose at the stamp is predicted from that of its late image
    posed.by_image = posed.pose;
    if (motion) {
      posed.pose = AnchoredPose::At(map, found->reference,
                                    found->T_WC * motion->Over(ToSeconds(posed.delay)));
    }
  }
  return posed;
}

std::optional<TrackedFrame> LostFrames::Search(const Map& map, const Neighbours& around,
                                               const LostFrame& lost) const {
  if (auto rough = Interpolated(map, around, lost.frame)) {
    if (auto found = Verified(map, around, lost, *std::move(rough), PoseOrigin::kMotion)) {
      return found;
    }
  }
  const auto verified = [&](const std::optional<Relocalization>& match, PoseOrigin origin) {
    if (!match) return std::optional<TrackedFrame>();
    TrackedFrame rough = Unmatched(lost.frame, match->T_WC);
    ForEachKind([&]<class Landmark>() {
      Apply(PartOf<Landmark>(match->matches), PartOf<Landmark>(rough));
    });
    return Verified(map, around, lost, std::move(rough), origin);
  };
  for (const std::optional<Neighbour>& neighbour : {around.before, around.after}) {
    if (!neighbour) continue;
    for (const KeyFrameId id :
         WithNeighbours(map, neighbour->reference, kSharedByPlace, kAroundReference)) {
      const auto match =
          reference_matcher_.MatchKeyFrame(*lost.frame.features, map, id, map.keyframe(id)->T_WC);
      if (auto found = verified(match, PoseOrigin::kReference)) return found;
    }
  }
  return verified(relocalizer_.Relocalize(*lost.frame.features, map), PoseOrigin::kPlace);
}

std::optional<TrackedFrame> LostFrames::Interpolated(const Map& map, const Neighbours& around,
                                                     const Frame& frame) const {
  const std::optional<Twist> motion = around.Motion();
  if (!motion) return std::nullopt;
  const auto& [before, after] = around;
  const Stamp since = frame.stamp - before->stamp, until = after->stamp - frame.stamp;
  TrackedFrame rough = Unmatched(frame, before->T_WC * motion->Over(ToSeconds(since)));
  const KeyFrameId nearer = since < until ? before->reference : after->reference;
  const KeyFrame& keyframe = *map.keyframe(nearer);
  Apply(matcher_.MatchLast(*frame.features, rough.T_WC, map, *keyframe.frame.features,
                           keyframe.points, kWide),
        rough.points);
  Apply(matcher_.Match(*frame.features, rough.T_WC, map, keyframe.lines, Taken(rough.lines)),
        rough.lines);
  if (!SolveFromLandmarks(model_, map, options_, &rough)) return std::nullopt;
  return rough;
}

std::optional<TrackedFrame> LostFrames::Verified(const Map& map, const Neighbours& around,
                                                 const LostFrame& lost, TrackedFrame rough,
                                                 PoseOrigin origin) const {
  const PerKind<LandmarkIds> in_view = MatchAround(matcher_, map, options_.local_keyframes, &rough);
  if (!SolveFromLandmarks(model_, map, options_, &rough) || !rough.open.empty()) {
    return std::nullopt;
  }
  const std::vector<KeyFrameId> views = ClosestObservers(map, rough, parameters_.recognized_views);
  const auto contradiction = DepthContradiction(rough.frame.features->depth_grid, rough.T_WC, views,
                                                map, grid_, model_.depth_noise());
  if (contradiction && *contradiction > parameters_.recognized_contradiction) return std::nullopt;
  rough.reference = views.front();
  const double found =
      Support(rough.num_points, rough.num_lines) / static_cast<double>(MatchedSupport(in_view));
  const Reach reach = ReachOf(map, around, rough);
  if (reach == Reach::kUnreachable) return std::nullopt;
  // It may be a similar place instead.
  const bool is_doubtful = origin == PoseOrigin::kPlace || reach == Reach::kUnknown;
  if (is_doubtful && found < parameters_.recognized_found * lost.usual_match_ratio) {
    return std::nullopt;
  }
  return rough;
}

LostFrames::Reach LostFrames::ReachOf(const Map& map, const Neighbours& around,
                                      const TrackedFrame& found) {
  const SubmapId root = *map.RootOf(found.reference);
  Reach reach = Reach::kUnknown;
  for (const std::optional<Neighbour>& neighbour : {around.before, around.after}) {
    if (!neighbour || neighbour->root != root) continue;
    const double dt = std::abs(ToSeconds(found.frame.stamp - neighbour->stamp));
    if (IsReachable(neighbour->T_WC.Inverse() * found.T_WC, dt)) {
      reach = Reach::kReachable;
    } else if (dt <= kReach) {
      return Reach::kUnreachable;
    }
  }
  return reach;
}

}  // namespace highwall
