#include "tracking/tracker.h"

#include <utility>

#include <highwall/internal/stage_timer.h>

#include "features/row_times.h"

namespace highwall {
namespace {

constexpr double kFollow = 0.05;  // weight of a frame in the mean match ratio
// Correlation of two views whose grey levels know the motion better than few landmarks do: below
// it, parts of the image are hidden in one of them or look different.
constexpr double kAlike = 0.97;

}  // namespace

SensorModelOptions SensorOptions(const TrackerOptions& options) {
  return {.has_row_times = options.timing != FrameTimingMode::kIgnored,
          .estimates_timing = options.timing == FrameTimingMode::kEstimated,
          .estimates_noise = options.learn_noise};
}

Tracker::Tracker(const MeasurementModel& model, const TrackerOptions& options,
                 const SensorModel& sensor, const TrackerParameters& parameters,
                 RunProfile* profile)
    : model_(model),
      sensor_(sensor),
      options_(options),
      parameters_(parameters),
      profile_(profile),
      matcher_(model),
      relocalizer_(model, parameters.relocalizer),
      reference_matcher_(model, parameters.reference),
      moving_(model, options.moving, parameters.moving),
      solver_(model, options_, moving_.grid(), state_, profile),
      verifier_(model, options_, parameters_, matcher_, moving_, solver_, state_),
      last_frame_(matcher_, options_, parameters_, solver_, state_),
      reference_keyframe_(reference_matcher_, state_),
      place_index_(relocalizer_),
      surfaces_(matcher_, options_, parameters_, solver_, state_),
      whole_image_(matcher_, options_, parameters_, moving_.grid(), solver_, state_) {
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
  const bool was_tracking = state_.last.has_value();
  const PoseConstraint* known = predicted ? &*predicted : nullptr;
  Frame frame = seen;
  frame.features = sensor_.WithNoise(seen.features);
  const Twist expected = Motion(known);
  if (const auto times = sensor_.TimingOf(seen); was_tracking && times) {
    moved_by_ = {*times, expected};
    if (times->colour_readout > 0.0) {
      frame.features = CompensatedToMiddleRow(*frame.features, model_.camera(),
                                              times->colour_readout, expected, times->direction);
    }
  }
  const TrackingQuery query{frame, map, known};
  PoseSearch search = Find(query);
  if (!search.best) {
    // With an IMU the landmarks of the last frame can be searched again after any time.
    if (!predicted) state_.last.reset();
    TrackedFrame lost = Unmatched(frame, predicted ? predicted->T_WC : Pose());
    lost.diagnostics = search.diagnostics;
    return {.frame = std::move(lost)};
  }
  LocalMatch& match = *search.best;
  TrackedFrame& tracked = match.frame;
  TrackingResult result{.counts = {std::move(match.in_view), tracked}};
  if (was_tracking && !tracked.relocalized) {
    result.motion =
        UpdateMotion(search.prediction_rejected ? query.WithoutPrediction() : query, &match);
  } else {
    state_.velocity.Reset();
    state_.is_continuous = false;
  }
  anchored_.reset();
  tracked.state = TrackingState::kTracking;
  tracked.by_image = true;
  state_.last = tracked;
  result.frame = tracked;
  // A pose by direct alignment gives no information about landmarks.
  if (match.Support() == 0) return result;
  state_.last_support = match.Support();
  state_.last_landmarks = frame.stamp;
  state_.mean_match_ratio +=
      (state_.mean_match_ratio > 0.0 ? kFollow : 1.0) * (tracked.found - state_.mean_match_ratio);
  moving_.objects().Remember(frame.stamp, frame.features->depth_grid, tracked.T_WC, tracked.moving,
                             tracked.reference, map);
  return result;
}

std::optional<FrameMotion> Tracker::UpdateMotion(const TrackingQuery& query, LocalMatch* match) {
  const PoseConstraint* predicted = query.prediction;
  TrackedFrame& tracked = match->frame;
  const ConstantVelocity before = state_.is_continuous ? state_.velocity : ConstantVelocity();
  imu_predicts_motion_ =
      predicted != nullptr && predicted->motion && state_.IsContinuous(*predicted->motion, tracked);
  // Also done while the row times are unknown: keyframes store the motion until they are known.
  if (imu_predicts_motion_) moved_by_.motion = *predicted->motion;
  state_.is_continuous = imu_predicts_motion_ || state_.IsContinuous(Motion(nullptr), tracked);
  if (state_.is_continuous && !imu_predicts_motion_ && match->Support() > 0) {
    FollowMotion(query, &tracked);
  }
  state_.velocity.Measure(state_.last->T_WC.Inverse() * tracked.T_WC,
                          state_.SinceLast(tracked.frame));
  if (!state_.is_continuous) return std::nullopt;
  FrameMotion motion{imu_predicts_motion_ ? moved_by_.motion : state_.velocity.twist()};
  if (anchored_) {
    motion.keyframe = *anchored_;
    motion.at_keyframe = state_.velocity.AtBeginning(before);
  }
  return motion;
}

void Tracker::FollowMotion(const TrackingQuery& query, TrackedFrame* tracked) {
  const auto times = sensor_.TimingOf(tracked->frame);
  if (!times) return;
  ConstantVelocity found = state_.velocity;
  found.Measure(state_.last->T_WC.Inverse() * tracked->T_WC, state_.SinceLast(tracked->frame));
  const RowMotion now{*times, found.twist()};
  if (!Differ(moved_by_, now, model_.camera(), MedianDepth(*state_.last->frame.features))) return;
  TrackedFrame again = *tracked;
  again.frame.features =
      MovedOtherwise(*tracked->frame.features, model_.camera(), moving_.grid(), moved_by_, now);
  if (!solver_.Solve(query, kMinMotionSupport, FallbackConstraint::kNone, &again)) return;
  *tracked = std::move(again);
  moved_by_ = now;
}

PoseSearch Tracker::Find(const TrackingQuery& query) const {
  PoseSearch search{.diagnostics = {.predicted = query.prediction != nullptr}};
  Try({&last_frame_, &reference_keyframe_}, query, &search);
  if (IsPredictionSuspect(query, search)) {
    PoseSearch without;
    Try({&last_frame_, &reference_keyframe_}, query.WithoutPrediction(), &without);
    search.prediction_rejected = search.Take(std::move(without.best));
  }
  Try({&place_index_, &surfaces_, &whole_image_}, query, &search);
  return search;
}

void Tracker::Try(std::initializer_list<const PoseSource*> sources, const TrackingQuery& query,
                  PoseSearch* search) const {
  for (const PoseSource* source : sources) {
    if (!source->IsDue(query, *search)) continue;
    StageTimer proposing(profile_, StageOf(source));
    PoseHypothesis hypothesis = source->Propose(query);
    proposing.Stop();
    const StageTimer timer(profile_, "local map");
    const bool is_alike = hypothesis.correlation >= kAlike;
    Verification verified = verifier_.Verify(query, std::move(hypothesis));
    // Grey levels hold the pose where landmarks are few, unless they contradict most of these.
    if (source == &whole_image_ && is_alike && search->best && verified.match &&
        2 * verified.match->Support() > search->best->Support()) {
      search->best.reset();
    }
    search->Add(std::move(verified));
  }
}

const char* Tracker::StageOf(const PoseSource* source) const {
  if (source == &last_frame_) return "prediction";
  if (source == &surfaces_) return "surfaces";
  return source == &whole_image_ ? "whole image" : "recognition";
}

bool Tracker::IsPredictionSuspect(const TrackingQuery& query, const PoseSearch& search) const {
  if (!state_.last || query.prediction == nullptr || !state_.is_continuous ||
      state_.SinceLast(query.frame) > ConstantVelocity::kLongestPrediction) {
    return false;
  }
  return !search.best || !state_.IsContinuous(state_.velocity.twist(), search.best->frame);
}

void Tracker::Anchor(const TrackedFrame& tracked, const KeyFrame& keyframe) {
  if (!state_.last) {
    // The first keyframe was not tracked: the next frame should match all its landmarks.
    state_.last_support = MatchedSupport(keyframe);
    state_.last_landmarks = tracked.frame.stamp;
    state_.velocity.Reset();
  }
  state_.last = tracked;
  state_.last->T_WC = keyframe.T_WC;
  PerKind<LandmarkIds>& matched = *state_.last;
  matched = keyframe;
  state_.last->reference = keyframe.id;
  if (!imu_predicts_motion_) anchored_ = keyframe.id;
}

void Tracker::Correct(const Pose& T_WC) {
  if (state_.last) state_.last->T_WC = T_WC;
}

std::optional<KeyFrameId> Tracker::reference() const {
  return state_.last ? std::optional(state_.last->reference) : std::nullopt;
}

void Tracker::Transform(const Pose& T_new_old) {
  if (state_.last) state_.last->T_WC = T_new_old * state_.last->T_WC;
}

std::optional<TrackedFrame> Tracker::ExtrapolateAtConstantVelocity(const Frame& frame) const {
  if (!state_.last || state_.SinceLast(frame) > ConstantVelocity::kLongestPrediction) {
    return std::nullopt;
  }
  TrackedFrame tracked = Unmatched(frame, state_.Extrapolate(frame));
  tracked.state = TrackingState::kTracking;
  tracked.reference = state_.last->reference;
  return tracked;
}

cv::Mat Tracker::DynamicMaskOf(const KeyFrame& keyframe, const Map& map) const {
  return moving_.objects().Find(keyframe.frame.stamp, keyframe.frame.features->depth_grid,
                                keyframe.T_WC, map, keyframe.submap);
}

}  // namespace highwall
