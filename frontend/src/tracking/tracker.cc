#include "tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/internal/median.h>

#include "features/row_times.h"
#include "map/covisibility.h"
#include "pose/depth_agreement.h"
#include "pose/support.h"
#include "tracking/landmark_observations.h"

namespace highwall {
namespace {

constexpr double kFollow = 0.05;      // weight of a frame in the mean match ratio
constexpr std::size_t kCompared = 3;  // keyframes whose depth must be consistent with a frame's

// Returns a frame with the relocalizer's matches.
TrackedFrame Matched(const Frame& frame, const Relocalization& found) {
  TrackedFrame tracked = Unmatched(frame, found.T_WC);
  Apply(found.points, tracked.points);
  Apply(found.lines, tracked.lines);
  tracked.tried_points = tracked.points;
  tracked.tried_lines = tracked.lines;
  return tracked;
}

template <class LandmarkId>
int Count(const std::vector<LandmarkId>& landmarks) {
  return static_cast<int>(
      std::count_if(landmarks.begin(), landmarks.end(), [](LandmarkId id) { return id != kNoId; }));
}

int Support(const std::vector<PointId>& points, const std::vector<LineId>& lines) {
  return highwall::Support(Count(points), Count(lines));
}

int Support(const TrackedFrame& tracked) {
  return Support(tracked.points, tracked.lines);
}

int NumCells(const cv::Mat& mask) {
  return mask.empty() ? 0 : cv::countNonZero(mask);
}

}  // namespace

SensorModelOptions SensorOptions(const TrackerOptions& options) {
  return {.has_row_times = options.timing != FrameTimingMode::kIgnored,
          .estimates_timing = options.timing == FrameTimingMode::kEstimated,
          .estimates_noise = options.learn_noise};
}

Tracker::Tracker(const MeasurementModel& model, const TrackerOptions& options,
                 const SensorModel& sensor)
    : model_(model),
      sensor_(sensor),
      options_(options),
      matcher_(model),
      relocalizer_(model, options.relocalizer, options.pose),
      moving_(model, options.moving, options.pose),
      aligner_(moving_.grid(), model.depth_noise(), options.surfaces.matcher, options.direct) {
  options_.Validate();
}

TrackingResult Tracker::Track(const Frame& seen, const Map& map,
                              const std::optional<PoseConstraint>& predicted) {
  moved_by_ = {};
  imu_predicts_motion_ = false;
  if (map.num_keyframes() == 0) {
    TrackedFrame none = Unmatched(seen, Pose());
    none.state = TrackingState::kInitializing;
    return {.frame = std::move(none)};
  }
  const bool was_tracking = last_.has_value();
  const PoseConstraint* known = predicted ? &*predicted : nullptr;
  Frame frame = seen;
  frame.features = sensor_.WithNoise(seen.features);
  const Twist expected = Motion(known);
  if (const auto times = sensor_.TimingOf(seen); was_tracking && times) {
    moved_by_ = {*times, expected};
    if (times->colour_readout > 0.0) {
      frame.features =
          CompensatedToMiddleRow(*frame.features, model_.camera(), times->colour_readout, expected);
    }
  }
  TrackingDiagnostics diagnostics{.predicted = predicted.has_value()};
  auto match = Find(frame, map, known, &diagnostics);
  if (!match) {
    // With an IMU the landmarks of the last frame can be searched again after any time.
    if (!predicted) last_.reset();
    TrackedFrame lost = Unmatched(frame, predicted ? predicted->T_WC : Pose());
    lost.diagnostics = diagnostics;
    return {.frame = std::move(lost)};
  }
  TrackedFrame& tracked = match->frame;
  TrackingResult result{.counts = {std::move(match->in_view), tracked.points, tracked.lines}};
  if (was_tracking && !tracked.relocalized) {
    result.motion = UpdateMotion(match->prediction_rejected ? nullptr : known, match->Support() > 0,
                                 map, &tracked);
  } else {
    velocity_.Reset();
    is_continuous_ = false;
  }
  anchored_.reset();
  tracked.state = TrackingState::kTracking;
  tracked.by_image = !predicted;
  last_ = tracked;
  result.frame = tracked;
  // A pose by direct alignment gives no information about landmarks.
  if (match->Support() == 0) return result;
  last_support_ = match->Support();
  last_landmarks_ = frame.stamp;
  mean_match_ratio_ +=
      (mean_match_ratio_ > 0.0 ? kFollow : 1.0) * (tracked.found - mean_match_ratio_);
  moving_.objects().Remember(frame.stamp, frame.features->depth_grid, tracked.T_WC, tracked.moving,
                             tracked.reference, map);
  return result;
}

Twist Tracker::Motion(const PoseConstraint* predicted) const {
  if (!last_) return {};
  if (predicted != nullptr && predicted->motion) return *predicted->motion;
  return is_continuous_ ? velocity_.twist() : Twist();
}

bool Tracker::IsContinuous(const Twist& expected, const TrackedFrame& tracked) const {
  // Above what a hand or a drone does to its camera, and below a cut in the recording.
  constexpr double kMaxAcceleration = 50.0;          // [m/s^2]
  constexpr double kMaxAngularAcceleration = 100.0;  // [rad/s^2]
  const double dt = SinceLast(tracked.frame);
  if (!(dt > 0.0 && dt <= ConstantVelocity::kLongestPrediction)) return false;
  const Twist found = Twist::Between(last_->T_WC.Inverse() * tracked.T_WC, dt);
  return (found.v - expected.v).norm() <= kMaxAcceleration * dt &&
         (found.omega - expected.omega).norm() <= kMaxAngularAcceleration * dt;
}

std::optional<FrameMotion> Tracker::UpdateMotion(const PoseConstraint* predicted,
                                                 bool has_landmarks, const Map& map,
                                                 TrackedFrame* tracked) {
  const ConstantVelocity before = is_continuous_ ? velocity_ : ConstantVelocity();
  imu_predicts_motion_ =
      predicted != nullptr && predicted->motion && IsContinuous(*predicted->motion, *tracked);
  // Also done while the row times are unknown: keyframes store the motion until they are known.
  if (imu_predicts_motion_) moved_by_.motion = *predicted->motion;
  is_continuous_ = imu_predicts_motion_ || IsContinuous(Motion(nullptr), *tracked);
  if (is_continuous_ && !imu_predicts_motion_ && has_landmarks)
    FollowMotion(map, predicted, tracked);
  velocity_.Measure(last_->T_WC.Inverse() * tracked->T_WC, SinceLast(tracked->frame));
  if (!is_continuous_) return std::nullopt;
  FrameMotion motion{imu_predicts_motion_ ? moved_by_.motion : velocity_.twist()};
  if (anchored_) {
    motion.keyframe = *anchored_;
    motion.at_keyframe = velocity_.AtBeginning(before);
  }
  return motion;
}

void Tracker::FollowMotion(const Map& map, const PoseConstraint* predicted, TrackedFrame* tracked) {
  const auto times = sensor_.TimingOf(tracked->frame);
  if (!times) return;
  ConstantVelocity found = velocity_;
  found.Measure(last_->T_WC.Inverse() * tracked->T_WC, SinceLast(tracked->frame));
  const RowMotion now{*times, found.twist()};
  if (!Differ(moved_by_, now, model_.camera(), MedianDepth(*last_->frame.features))) return;
  TrackedFrame again = *tracked;
  again.frame.features =
      MovedOtherwise(*tracked->frame.features, model_.camera(), moving_.grid(), moved_by_, now);
  if (!Solve(again, map, options_.min_motion_support, predicted, FallbackConstraint::kNone)) return;
  *tracked = std::move(again);
  moved_by_ = now;
}

std::optional<Tracker::LocalMatch> Tracker::Find(const Frame& frame, const Map& map,
                                                 const PoseConstraint* predicted,
                                                 TrackingDiagnostics* diagnostics) const {
  std::optional<LocalMatch> match;
  if (last_) match = Follow(frame, map, predicted, diagnostics);
  if (!match) match = Recognize(Relocalize(frame, map), map, diagnostics);
  if (match || !last_ || predicted != nullptr) return match;
  if (options_.surfaces.enabled) {
    match =
        TrackLocalMap(TrackMotion(frame, map, nullptr, FallbackConstraint::kSurfaces, diagnostics),
                      map, nullptr, FallbackConstraint::kSurfaces, diagnostics);
    if (match && Contradicts(*match, map)) match.reset();
  }
  // The whole image determines the pose only if most of it is static.
  constexpr double kMost = 0.5;
  const bool stands = diagnostics->masked_share < kMost;
  if (!match && stands && options_.direct.enabled) match = AlignDirectly(frame, map, diagnostics);
  return match;
}

std::optional<Tracker::LocalMatch> Tracker::AlignDirectly(const Frame& frame, const Map& map,
                                                          TrackingDiagnostics* diagnostics) const {
  const KeyFrame* reference = map.keyframe(last_->reference);
  // Each such pose depends on the one before, or on a view that is left behind.
  const double held = ToSeconds(frame.stamp - last_landmarks_);
  if (reference == nullptr || held > ConstantVelocity::kLongestPrediction) return std::nullopt;
  const Pose expected = last_->T_WC * velocity_.Predict(SinceLast(frame));
  auto aligned = aligner_.Align(*reference->frame.features, reference->depth_grid, reference->T_WC,
                                *frame.features, expected);
  if (!aligned) {
    const FrameFeatures& last = *last_->frame.features;
    aligned = aligner_.Align(last, Standing(last.depth_grid, last_->moving), last_->T_WC,
                             *frame.features, expected);
  }
  if (!aligned) return std::nullopt;
  const PoseConstraint& known = aligned->pose;
  auto match = TrackAbout(known, frame, map, diagnostics);
  if (!match) {
    match = LocalMatch{Unmatched(frame, known.T_WC), {}};
    match->frame.reference = reference->id;
    match->frame.information = known.sqrt_information.transpose() * known.sqrt_information;
    match->frame.open = FindUnobservableDirections(match->frame.information, known.T_WC,
                                                   aligned->depth, options_.degeneracy);
  }
  if (Contradicts(match->frame, AroundReference(map, kCompared), map)) return std::nullopt;
  return match;
}

std::vector<KeyFrameId> Tracker::AroundReference(const Map& map, std::size_t most) const {
  return WithNeighbours(map, last_->reference, 1, static_cast<int>(most) - 1);
}

std::optional<Tracker::LocalMatch> Tracker::TrackAbout(const PoseConstraint& known,
                                                       const Frame& frame, const Map& map,
                                                       TrackingDiagnostics* diagnostics) const {
  const std::vector<KeyFrameId> local =
      AroundReference(map, static_cast<std::size_t>(options_.local_keyframes));
  TrackedFrame rough = Unmatched(frame, known.T_WC);
  Apply(matcher_.MatchPoints(*frame.features, known.T_WC, map, map.SeenBy<MapPoint>(local),
                             Taken(rough.points)),
        rough.points);
  Apply(matcher_.MatchLines(*frame.features, known.T_WC, map, map.SeenBy<MapLine>(local),
                            Taken(rough.lines)),
        rough.lines);
  if (!Solve(rough, map, options_.min_predicted_support, &known, FallbackConstraint::kNone))
    return std::nullopt;
  return TrackLocalMap(std::move(rough), map, &known, FallbackConstraint::kNone, diagnostics);
}

std::optional<Tracker::LocalMatch> Tracker::Follow(const Frame& frame, const Map& map,
                                                   const PoseConstraint* predicted,
                                                   TrackingDiagnostics* diagnostics) const {
  auto match = FollowLast(frame, map, predicted, diagnostics);
  if (predicted == nullptr || !is_continuous_ ||
      SinceLast(frame) > ConstantVelocity::kLongestPrediction)
    return match;
  if (match && IsContinuous(velocity_.twist(), match->frame)) return match;
  TrackingDiagnostics without;
  auto other = FollowLast(frame, map, nullptr, &without);
  if (!other || (match && other->Support() <= match->Support())) return match;
  other->prediction_rejected = true;
  return other;
}

std::optional<Tracker::LocalMatch> Tracker::FollowLast(const Frame& frame, const Map& map,
                                                       const PoseConstraint* predicted,
                                                       TrackingDiagnostics* diagnostics) const {
  if (predicted == nullptr) diagnostics->shift = Shift(frame);
  auto rough = TrackMotion(frame, map, predicted, FallbackConstraint::kNone, diagnostics);
  const bool inconsistent = rough && IsInconsistent(*rough);
  auto match =
      TrackLocalMap(std::move(rough), map, predicted, FallbackConstraint::kNone, diagnostics);
  // A pose that most matches contradict must at least be observable in every direction.
  if (match && inconsistent && !match->frame.open.empty()) match.reset();
  const bool doubtful = match && predicted == nullptr && IsDoubtful(*match);
  // A camera that was moved elsewhere may see a similar place.
  if (match && predicted == nullptr && (doubtful || FindsLittle(*match)) &&
      Contradicts(*match, map)) {
    match.reset();
  }
  if (match && !inconsistent && !doubtful) return match;
  auto other = Recognize(TrackReference(frame, map), map, diagnostics);
  if (other && (!match || other->Support() > match->Support())) match = std::move(other);
  return match;
}

std::optional<Tracker::LocalMatch> Tracker::Recognize(std::optional<TrackedFrame> rough,
                                                      const Map& map,
                                                      TrackingDiagnostics* diagnostics) const {
  auto match =
      TrackLocalMap(std::move(rough), map, nullptr, FallbackConstraint::kNone, diagnostics);
  if (match && LooksAlikeOnly(*match, map)) match.reset();
  return match;
}

void Tracker::Anchor(const TrackedFrame& tracked, const KeyFrame& keyframe) {
  if (!last_) {
    // The first keyframe was not tracked: the next frame should match all its landmarks.
    last_support_ = Support(keyframe.points, keyframe.lines);
    last_landmarks_ = tracked.frame.stamp;
    velocity_.Reset();
  }
  last_ = tracked;
  last_->T_WC = keyframe.T_WC;
  last_->points = keyframe.points;
  last_->lines = keyframe.lines;
  last_->reference = keyframe.id;
  if (!imu_predicts_motion_) anchored_ = keyframe.id;
}

void Tracker::Correct(const Pose& T_WC) {
  if (last_) last_->T_WC = T_WC;
}

std::optional<KeyFrameId> Tracker::reference() const {
  return last_ ? std::optional(last_->reference) : std::nullopt;
}

void Tracker::Transform(const Pose& T_new_old) {
  if (last_) last_->T_WC = T_new_old * last_->T_WC;
}

double Tracker::SinceLast(const Frame& frame) const {
  return ToSeconds(frame.stamp - last_->frame.stamp);
}

double Tracker::Shift(const Frame& frame) const {
  const Pose T = velocity_.Predict(SinceLast(frame));
  return model_.camera().fx * (T.Angle() + T.p().norm() / MedianDepth(*last_->frame.features));
}

std::optional<TrackedFrame> Tracker::ExtrapolateAtConstantVelocity(const Frame& frame) const {
  if (!last_ || SinceLast(frame) > ConstantVelocity::kLongestPrediction) return std::nullopt;
  TrackedFrame tracked = Unmatched(frame, last_->T_WC * velocity_.Predict(SinceLast(frame)));
  tracked.state = TrackingState::kTracking;
  tracked.reference = last_->reference;
  return tracked;
}

std::optional<TrackedFrame> Tracker::TrackMotion(const Frame& frame, const Map& map,
                                                 const PoseConstraint* predicted,
                                                 FallbackConstraint fallback,
                                                 TrackingDiagnostics* diagnostics) const {
  // A landmark may have been removed, and the last frame's reference moved, since it was tracked.
  std::optional<TrackedFrame> best;
  for (const double radius_scale : {1.0, 2.0}) {
    TrackedFrame tracked =
        Unmatched(frame, predicted != nullptr ? predicted->T_WC
                                              : last_->T_WC * velocity_.Predict(SinceLast(frame)));
    Apply(matcher_.MatchLast(*frame.features, tracked.T_WC, map, *last_->frame.features,
                             last_->points, radius_scale),
          tracked.points);
    Apply(
        matcher_.MatchLines(*frame.features, tracked.T_WC, map, last_->lines, Taken(tracked.lines)),
        tracked.lines);
    const bool solved = Solve(tracked, map, options_.min_motion_support, predicted, fallback);
    diagnostics->tried =
        std::max(diagnostics->tried, Support(tracked.tried_points, tracked.tried_lines));
    if (!solved) continue;
    diagnostics->agreed = std::max(diagnostics->agreed, Support(tracked));
    if (!IsInconsistent(tracked)) return tracked;
    if (!best || Support(tracked) > Support(*best)) best = std::move(tracked);
  }
  return best;
}

std::optional<TrackedFrame> Tracker::TrackReference(const Frame& frame, const Map& map) const {
  if (map.keyframe(last_->reference) == nullptr) return std::nullopt;
  const auto found =
      relocalizer_.MatchKeyFrame(*frame.features, map, last_->reference, last_->T_WC);
  if (!found) return std::nullopt;
  return Matched(frame, *found);
}

std::optional<TrackedFrame> Tracker::Relocalize(const Frame& frame, const Map& map) const {
  const auto found = relocalizer_.Relocalize(*frame.features, map);
  if (!found) return std::nullopt;
  TrackedFrame tracked = Matched(frame, *found);
  tracked.relocalized = true;
  return tracked;
}

std::optional<TrackedFrame> Tracker::Reverified(TrackedFrame rough, int support, const Map& map,
                                                const PoseConstraint* predicted) const {
  constexpr double kAgree = 0.5, kLeft = 0.5;
  // The surfaces are those around the last frame.
  if (!options_.surfaces.enabled || rough.relocalized) return std::nullopt;
  const cv::Mat moving = std::exchange(rough.moving, cv::Mat());
  const auto steady = MatchLocalMap(rough, map, predicted, FallbackConstraint::kSurfaces);
  const double enough = std::max<double>(options_.surfaces.min_support, kAgree * support);
  if (!steady || moving_.SupportBeside(steady->frame, moving) < enough ||
      Contradicts(*steady, map)) {
    return std::nullopt;
  }
  // All tried matches are tested, because that pose does not look for dynamic landmarks where they
  // are.
  rough.T_WC = steady->frame.T_WC;
  rough.moving = moving_.Find(rough, map);
  if (NumCells(rough.moving) > kLeft * NumCells(moving)) return std::nullopt;
  return rough;
}

cv::Mat Tracker::DynamicMaskOf(const KeyFrame& keyframe, const Map& map) const {
  return moving_.objects().Find(keyframe.frame.stamp, keyframe.frame.features->depth_grid,
                                keyframe.T_WC, map, keyframe.submap);
}

std::optional<Tracker::LocalMatch> Tracker::TrackLocalMap(std::optional<TrackedFrame> rough,
                                                          const Map& map,
                                                          const PoseConstraint* predicted,
                                                          FallbackConstraint fallback,
                                                          TrackingDiagnostics* diagnostics) const {
  if (!rough) return std::nullopt;
  const auto all = static_cast<double>(rough->points.size() + rough->lines.size());
  const auto match_rest = [&](TrackedFrame rest) {
    moving_.MaskOut(rest);
    diagnostics->masked_share =
        1.0 - static_cast<double>(rest.points.size() + rest.lines.size()) / all;
    return MatchLocalMap(std::move(rest), map, predicted, fallback);
  };
  rough->moving = moving_.Find(*rough, map);
  auto match = match_rest(*rough);
  if (rough->moving.empty()) return match;
  const double masked_share = diagnostics->masked_share;
  auto reverified = Reverified(std::move(*rough), match ? match->Support() : 0, map, predicted);
  auto again = reverified ? match_rest(std::move(*reverified)) : std::nullopt;
  if (again) return again;
  diagnostics->masked_share = masked_share;
  return match;
}

std::optional<Tracker::LocalMatch> Tracker::MatchLocalMap(TrackedFrame rough, const Map& map,
                                                          const PoseConstraint* predicted,
                                                          FallbackConstraint fallback) const {
  LocalMatch match{std::move(rough), {}};
  TrackedFrame& tracked = match.frame;
  match.in_view = MatchAround(matcher_, map, options_.local_keyframes, &tracked);
  if (!Solve(tracked, map, options_.min_support, predicted, fallback)) return std::nullopt;
  tracked.reference = map.Observers(tracked.points, tracked.lines).front().first;
  tracked.found = static_cast<double>(match.Support()) / static_cast<double>(match.SupportInView());
  return match;
}

int Tracker::LocalMatch::Support() const {
  return highwall::Support(frame.num_points, frame.num_lines);
}

std::size_t Tracker::LocalMatch::SupportInView() const {
  return highwall::Support(in_view.points.size(), in_view.lines.size());
}

bool Tracker::IsInconsistent(const TrackedFrame& rough) const {
  return Support(rough.points, rough.lines) <
         options_.doubtful_agreement * Support(rough.tried_points, rough.tried_lines);
}

bool Tracker::IsDoubtful(const LocalMatch& match) const {
  return match.Support() < options_.doubtful_share * static_cast<double>(match.SupportInView()) ||
         match.Support() < options_.doubtful_drop * last_support_;
}

bool Tracker::FindsLittle(const LocalMatch& match) const {
  return match.frame.found < options_.recognized_found * mean_match_ratio_;
}

bool Tracker::LooksAlikeOnly(const LocalMatch& match, const Map& map) const {
  return FindsLittle(match) || Contradicts(match, map);
}

bool Tracker::Contradicts(const LocalMatch& match, const Map& map) const {
  std::vector<KeyFrameId> views;
  for (const auto& [id, shared] : map.Observers(match.frame.points, match.frame.lines)) {
    if (views.size() == kCompared) break;
    views.push_back(id);
  }
  return Contradicts(match.frame, views, map);
}

bool Tracker::Contradicts(const TrackedFrame& tracked, std::span<const KeyFrameId> views,
                          const Map& map) const {
  const auto contradiction = DepthContradiction(tracked.frame.features->depth_grid, tracked.T_WC,
                                                views, map, moving_.grid(), model_.depth_noise());
  return contradiction && *contradiction > options_.recognized_contradiction;
}

bool Tracker::Solve(TrackedFrame& tracked, const Map& map, int min_support,
                    const PoseConstraint* predicted, FallbackConstraint fallback) const {
  const LandmarkObservations seen = LandmarksSeen(model_, map, tracked);
  tracked.tried_points = tracked.points;
  tracked.tried_lines = tracked.lines;
  PoseSolverOptions options = options_.pose;
  options.min_support =
      predicted != nullptr ? std::min(min_support, options_.min_predicted_support) : min_support;
  std::vector<PointToPlaneRow> planes;
  if (fallback == FallbackConstraint::kSurfaces) {
    planes = MatchSurfaces(tracked, map);
    options.min_support = options_.surfaces.min_support;
  }
  const auto solution = SolvePose(tracked.T_WC, model_.projection(), seen.points, seen.lines,
                                  options, predicted, planes);
  if (!solution) return false;
  if (fallback == FallbackConstraint::kSurfaces &&
      (solution->num_planes < options_.surfaces.min_rows ||
       !FindUnobservableDirections(solution->information, solution->T_WC, solution->depth,
                                   {.max_sigma = options_.surfaces.max_sigma})
            .empty())) {
    return false;
  }
  TakePose(seen, *solution, options_.degeneracy, &tracked);
  return true;
}

std::vector<PointToPlaneRow> Tracker::MatchSurfaces(const TrackedFrame& tracked,
                                                    const Map& map) const {
  const KeyFrame* reference = last_ ? map.keyframe(last_->reference) : nullptr;
  const cv::Mat& depth = tracked.frame.features->depth_grid;
  if (reference == nullptr || depth.empty() || reference->depth_grid.empty()) return {};
  const DepthGrid& grid = moving_.grid();
  std::vector<SurfacePatch> patches =
      FindPatches(reference->depth_grid, grid, model_.depth_noise(), options_.surfaces.matcher);
  for (SurfacePatch& patch : patches) {
    patch.a = reference->T_WC * patch.a;
    patch.n = reference->T_WC.q() * patch.n;
  }
  return MatchPatches(patches, depth, tracked.moving, tracked.T_WC, grid, model_.depth_noise(),
                      options_.surfaces.matcher);
}

}  // namespace highwall
