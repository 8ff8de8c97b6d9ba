#include "system/slam_system_impl.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/features/depth_correction.h>
#include <highwall/frontend/input/depth_stamp.h>
#include <highwall/frontend/local/global_adjustment.h>
#include <highwall/frontend/map/anchored_pose.h>
#include <highwall/frontend/map/feature_type_mismatch.h>
#include <highwall/frontend/tracking/standard_keyframe_policy.h>
#include <highwall/internal/stage_timer.h>

#include "features/row_times.h"
#include "inertial/inertial_prior.h"
#include "input/depth_unit.h"
#include "map/covisibility.h"
#include "pose/support.h"
#include "system/map_memory.h"

namespace highwall {
namespace {

// Multiple of the search window: a larger image shift smears the image, and the next is unknown.
constexpr double kFarOff = 4.0;
// Number of keyframes for the noise estimate: those that an adjustment has moved together.
constexpr int kLearnedFrom = 10;

// Returns which of the ids are those of landmarks.
template <class Ids>
std::vector<bool> Assigned(const Ids& ids) {
  std::vector<bool> assigned(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) assigned[i] = ids[i] != kNoId;
  return assigned;
}

// Returns the information of a keyframe's observation over that of a detection in an image: corners
// that are refined have an error of 0.22 px, others of 0.42 px
// (docs/lab/2026-11-points-in-rooms.md).
template <class Landmark>
double Worth(const Map& map, const Observation& observation) {
  constexpr double kRefined = 3.6;
  if constexpr (std::is_same_v<Landmark, MapPoint>) {
    const FrameFeatures& features = *map.keyframe(observation.keyframe)->frame.features;
    if (features.points[static_cast<std::size_t>(observation.index)].refined) return kRefined;
  }
  return 1.0;
}

// Returns how many detections as accurate as those of an image a landmark is the mean of; 1 without
// landmarks.
double MeanObservers(const Map& map, const PerKind<LandmarkIds>& landmarks) {
  double observations = 0.0;
  std::size_t matched = 0;
  ForEachKind([&]<class Landmark>() {
    for (const Id<Landmark> id : PartOf<Landmark>(landmarks)) {
      const Landmark* const landmark = map.Find(id);
      if (landmark == nullptr) continue;
      for (const Observation& o : landmark->observations) observations += Worth<Landmark>(map, o);
      ++matched;
    }
  });
  return matched == 0 ? 1.0 : observations / static_cast<double>(matched);
}

}  // namespace

SlamSystem::Impl::Impl(const RgbdSensor& sensor, const SlamOptions& options, SlamInputs inputs)
    : options_((options.Validate(), options)),
      profile_(inputs.profile),
      builder_(sensor, options.frame, std::move(inputs.points), std::move(inputs.lines),
               options.threads > 0, kDepthSpreadShare, profile_),
      model_(sensor, options.measurement, inputs.imu ? inputs.imu->T_BC : Pose(),
             builder_.feature_type().pyramid),
      sensor_(model_, SensorOptions(options.tracker), sensor.timing),
      tracker_(model_, options.tracker, sensor_, {}, profile_),
      policy_(inputs.keyframe_policy ? std::move(inputs.keyframe_policy)
                                     : std::make_shared<StandardKeyFramePolicy>(options.keyframes)),
      refiner_(model_, sensor.camera, options.refinement, options.tracker, options.threads > 0, {},
               profile_),
      lost_frames_(model_, sensor.camera, options.tracker,
                   static_cast<std::size_t>(options.refinement.waiting), {}, profile_),
      mapper_(model_, options.mapper, options.threads > 0, {}, profile_),
      loop_closer_(model_, options.loops, options.threads, kGlobalAdjustment, profile_),
      factor_adjuster_(model_, options.factors, options.loops.graph, options.threads, profile_),
      depth_pattern_(sensor.camera, options.depth_pattern, kGlobalAdjustment, options.threads,
                     profile_),
      worker_(mapper_, {&loop_closer_, &factor_adjuster_, &depth_pattern_}),
      pending_(model_.T_BC().Inverse(), options.factors.max_gap),
      map_(std::move(inputs.map)),
      release_(options.tracker.moving.enabled ? kReleaseDelay : 0.0),
      uncertainty_(options.inertial.visual_noise),
      colour_delay_(sensor, builder_.depth_grid()) {
  if (inputs.imu) {
    inertial_.emplace(*inputs.imu, options.inertial, model_, options.threads > 0, profile_);
  }
  factor_adjuster_.Adopt(map_);
  const auto ids = map_.keyframe_ids();
  const FeatureType& kind = builder_.feature_type();
  if (const auto clash = FindMismatch(map_, kind); clash && !ids.empty()) {
    throw InvalidArgument("SlamSystem: the points of the map are by " + clash->first +
                          ", those of its images would be by " + clash->second);
  }
  map_.SetFeatureType(kind);
  HIGHWALL_REQUIRE(!options.localize_only || (!ids.empty() && !inputs.imu),
                   "SlamOptions::localize_only needs a map, and works without an IMU");
  if (!ids.empty()) {
    last_given_keyframe_ = ids.back();
    submap_keyframes_ = kMinSubmapKeyFrames;  // mature
    const auto newest = WithNeighbours(map_, ids.back(), kSharedByPlace, kLearnedFrom);
    sensor_.LearnNoise(newest, last_given_keyframe_, &map_);
  }
}

ImuSampleStatus SlamSystem::Impl::AddImu(const ImuSample& sample) {
  HIGHWALL_REQUIRE(inertial_, "SlamSystem::AddImu: the system was made without an IMU");
  return inertial_->AddSample(sample);
}

void SlamSystem::Impl::AddFactor(PoseFactor factor) {
  HIGHWALL_REQUIRE(!options_.localize_only,
                   "SlamSystem::AddFactor: SlamOptions::localize_only keeps the map as it is");
  factor.Validate();
  if (factor.frame != kNoId) (void)map_.factors().frame(factor.frame);  // throws if there is none
  pending_.Add(std::move(factor));
}

std::optional<Pose> SlamSystem::Impl::T_FW(ReferenceFrameId frame) const {
  return map_.factors().T_FW(frame, tracked_.LargestWorld(map_).value_or(kFirstSubmap));
}

FrameResult SlamSystem::Impl::Track(const RgbdImage& image) {
  stamps_.RequireNext(image.stamp);
  FrameResult result;
  StageTimer timer(profile_, "frame", &result.times.total);
  result.stamp = image.stamp;
  builder_.Check(image);
  // Verified once only, as later images may have distant depth alone.
  if (!metric_) metric_ = IsMetric(image.depth);
  result.repeated = Repeats(image);
  // Before this image's depth is corrected: no keyframe must be made with a partial correction.
  const bool corrected = CorrectDepth(result);
  // Figure 2 of Xiao et al. 2025: tracking (section 3: points, lines, IMU), local mapping, loops.
  RgbdImage at_once = image;
  const Frame frame = Extract(&at_once, result);
  {
    const StageTimer applying(profile_, "results of other threads", &result.times.loops);
    ApplyResults(result);
  }
  DoWhatIsDue(result);
  TrackedFrame tracked = result.repeated ? Extrapolate(frame, result) : Estimate(frame, result);
  // Before a keyframe is adjusted: it states something about the pose that was tracked.
  const std::optional<ImageInformation> information = InformationOf(tracked);
  result.uncertainty = UncertaintyOf(tracked, result);
  if (!result.repeated && !options_.localize_only && WantsKeyFrame(tracked)) {
    if (due_.lens_check) CheckLens(false);  // of the keyframe before: no frame came in between
    InsertKeyFrame(tracked, result);
    due_ = {.loop_search = true, .lens_check = true};
    if (options_.threads == 0) {
      DoWhatIsDue(result);
      // If there was a loop, it is closed by now, and the frame belongs to the corrected map.
      tracked.T_WC = map_.keyframe(last_keyframe_)->T_WC;
    }
    AdjustToFactors(tracked, result);
    if (worker_.IsFree() && backlog_.IsEmpty()) {
      depth_pattern_.Begin(map_, model_, submap_, last_given_keyframe_);
    }
    if (options_.threads == 0) DoWhatIsDue(result);
  }
  Report(tracked, information, result);
  RefineFrames(result);
  pending_.Attach(tracked_.frames(), &map_);
  Notify(result, at_once, corrected);
  timer.Stop();
  if (callbacks_.on_frame) callbacks_.on_frame(result);
  return result;
}

void SlamSystem::Impl::DoWhatIsDue(FrameResult& result) {
  if (std::exchange(due_.loop_search, false)) {
    LookForLoop(result);
  } else if (std::exchange(due_.lens_check, false)) {
    CheckLens(false);
  }
}

bool SlamSystem::Impl::CorrectDepth(FrameResult& result) {
  if (!depth_pattern_.HasResult()) return false;
  const StageTimer timer(profile_, "results of other threads", &result.times.loops);
  bool found = false;
  EditWorld(result, [&] { found = depth_pattern_.Finish(&map_); });
  return found;
}

FrameBuilder::DepthChange SlamSystem::Impl::DepthChangeOf(Stamp stamp) {
  DepthCorrection correction{.pattern = depth_pattern_.pattern()};
  const bool knows_rows = options_.tracker.timing != FrameTimingMode::kIgnored;
  if (knows_rows) {
    std::optional<PoseConstraint> predicted;
    if (inertial_) predicted = inertial_->Predict(stamp);
    correction.motion = tracker_.Motion(predicted ? &*predicted : nullptr);
    correction.timing = sensor_.timing();
  }
  return [this, correction, knows_rows](RgbdImage* image) {
    // The readings of an IMU belong to the stamps, not to the time of a late image.
    if (!inertial_) colour_delay_.Apply(false, tracker_.Motion(nullptr), image);
    DepthCorrection at_once = correction;
    if (knows_rows) at_once.timing.depth_delay += DepthDelay(*image);
    if (!at_once.IsIdentity()) image->depth = at_once.Apply(image->depth, builder_.camera());
  };
}

cv::Mat SlamSystem::Impl::CorrectedDepth(KeyFrameId id, const cv::Mat& depth) const {
  DepthCorrection correction{.pattern = depth_pattern_.pattern()};
  const KeyFrame* const keyframe = map_.keyframe(id);
  const RowMotion* const rows = keyframe ? sensor_.RowsOf(id) : nullptr;
  if (rows != nullptr) {
    correction.motion = rows->motion;
    correction.timing = rows->timing;
  }
  return correction.Apply(depth, builder_.camera());
}

Frame SlamSystem::Impl::Extract(RgbdImage* image, FrameResult& result) {
  const StageTimer timer(profile_, "features", &result.times.features);
  // From here on the image counts; one that was rejected leaves no trace.
  stamps_.Accept(image->stamp);
  if (!inertial_) clock_.Add(image->stamp);  // the readings of an IMU have the right unit
  if (result.repeated) {
    if (!inertial_) colour_delay_.Apply(true, tracker_.Motion(nullptr), image);
    return {next_index_++, image->stamp, std::make_shared<const FrameFeatures>()};
  }
  FrameBuilderTimes builder_times;
  const auto features = builder_.Build(image, DepthChangeOf(image->stamp), &builder_times);
  if (!inertial_) colour_delay_.SetReference(features);
  result.times.points = builder_times.points;
  result.times.lines = builder_times.lines;
  result.points = static_cast<int>(features->points.size());
  result.lines = static_cast<int>(features->lines.size());
  // The frame is one of the time at which its colour was taken.
  return {next_index_++, image->stamp - colour_delay_.delay(), features, DepthDelay(*image)};
}

TrackedFrame SlamSystem::Impl::Estimate(const Frame& frame, FrameResult& result) {
  const StageTimer timer(profile_, "tracking", &result.times.tracking);
  std::optional<PoseConstraint> predicted;
  if (inertial_) predicted = inertial_->Predict(frame.stamp);
  TrackedFrame tracked = TrackInMap(frame, predicted);
  ChooseSubmap(tracked, result);
  const bool starts = submap_keyframes_ == 0;
  if (inertial_ && !starts) Fuse(Observe(tracked), tracked, result);
  // In a given map the lost timeout begins with the first image.
  if (tracked.state == TrackingState::kLost && !posed_) posed_ = submap_begin_ = frame.stamp;
  if (!HasPose(tracked.state) && CanBegin(tracked)) BeginSubmap(tracked, result);
  if (HasPose(tracked.state)) posed_ = frame.stamp;
  return tracked;
}

TrackedFrame SlamSystem::Impl::TrackInMap(const Frame& frame,
                                          const std::optional<PoseConstraint>& predicted) {
  TrackingResult result = tracker_.Track(frame, map_, predicted);
  const TrackedFrame& tracked = result.frame;
  result.counts.AddTo(&map_);
  if (result.motion) {
    const StageTimer timer(profile_, "timing");
    sensor_.LearnTiming(
        {tracked.frame.stamp, *tracked.frame.features, tracked.points, tracked.T_WC}, map_,
        *result.motion);
  }
  return std::move(result.frame);
}

bool SlamSystem::Impl::Repeats(const RgbdImage& image) {
  // There is nothing to extrapolate before the camera has been in a map or lost in it.
  return repeated_.Update(image.bgr) && posed_;
}

TrackedFrame SlamSystem::Impl::Extrapolate(const Frame& frame, FrameResult& result) {
  const StageTimer timer(profile_, "tracking", &result.times.tracking);
  TrackedFrame tracked;
  tracked.frame = frame;
  if (inertial_) {
    InertialOdometry::Observation nothing;
    nothing.image = frame.stamp;
    Fuse(nothing, tracked, result);
  }
  if (!HasPose(tracked.state))
    tracked = tracker_.ExtrapolateAtConstantVelocity(frame).value_or(std::move(tracked));
  tracked.submap = submap_;
  if (HasPose(tracked.state)) posed_ = frame.stamp;
  return tracked;
}

LossReason SlamSystem::Impl::ReasonOf(const TrackedFrame& lost) const {
  const double motion_radius = options_.measurement.motion_radius;
  return highwall::ReasonOf(
      *lost.frame.features, lost.diagnostics,
      {.min_features = options_.keyframes.min_features,
       .min_corner = static_cast<double>(options_.frame.orb.min_fast_threshold),
       .usual_sharpness = usual_sharpness_,
       .searched = kFarOff * motion_radius});
}

void SlamSystem::Impl::Report(const TrackedFrame& tracked,
                              const std::optional<ImageInformation>& information,
                              FrameResult& result) {
  result.state = tracked.state;
  result.relocalized = tracked.relocalized;
  result.T_WC = tracked.T_WC;
  const Stamp delay = result.colour_delay = result.stamp - tracked.frame.stamp;
  if (delay > 0) result.T_WC = result.T_WC * tracker_.Motion(nullptr).Over(ToSeconds(delay));
  if (HasPose(tracked.state)) result.submap = map_.Root(submap_);
  result.matched_points = tracked.num_points;
  result.matched_lines = tracked.num_lines;
  if (!result.repeated) {
    result.features = tracked.frame.features;
    result.matched = {Assigned(tracked.points), Assigned(tracked.lines)};
  }
  result.unobservable_directions = tracked.open;
  result.moving = ToImage(tracked.moving);
  if (!HasPose(tracked.state)) {
    RememberLost(tracked, result.stamp);
    // If tracking was lost already, the reason is that of the previous image.
    if (!result.repeated) {
      lost_for_ = ReasonOf(tracked);
    } else if (!lost_for_) {
      lost_for_ = LossReason::kRepeatedImage;
    }
    result.reason = lost_for_;
    return;
  }
  lost_for_.reset();
  if (!inertial_ && !result.repeated) FollowSharpness(*tracked.frame.features);
  PosedFrame posed{result.stamp, AnchoredPose::At(map_, tracked.reference, result.T_WC),
                   information};
  if (delay > 0) {
    posed.by_image = AnchoredPose::At(map_, tracked.reference, tracked.T_WC);
    posed.delay = delay;
  }
  if (inertial_) {
    if (tracked.by_image) posed.by_image = image_pose_;
    posed.readings = ReadingsFromBefore();
  }
  tracked_.Add(posed, map_.keyframe(map_.ActiveKeyFrameOf(tracked.reference)->first)->submap);
  if (!inertial_ && (delay > 0 || result.repeated)) {
    if (const auto predicted = tracked_.PredictNewest(map_)) {
      result.T_WC = *predicted;
      tracked_.mutable_frames()->back().pose =
          AnchoredPose::At(map_, tracked.reference, *predicted);
    }
  }
  refiner_.Add(tracked, tracked_.frames().back(), tracker_.moved_by(), depth_pattern_.pattern(),
               last_keyframe_);
}

std::optional<ImageInformation> SlamSystem::Impl::InformationOf(const TrackedFrame& tracked) const {
  if (submap_keyframes_ == 0) return std::nullopt;
  if (tracked.state != TrackingState::kTracking) return ImageInformation(ImageInformation::Zero());
  return InformationInCamera(tracked.information, tracked.T_WC);
}

std::optional<PoseUncertainty> SlamSystem::Impl::UncertaintyOf(const TrackedFrame& tracked,
                                                               const FrameResult& result) {
  if (!HasPose(tracked.state)) return std::nullopt;
  const Stamp stamp = tracked.frame.stamp;
  if (submap_keyframes_ == 0 || tracked.reference == kNoId) return uncertainty_.OfOrigin(stamp);
  const AnchoredPose pose = AnchoredPose::At(map_, tracked.reference, tracked.T_WC);
  if (inertial_ && inertial_->T_WC() && result.inertial && result.inertial->estimate) {
    const CameraPoseEstimate camera = CameraOf(*result.inertial->estimate, inertial_->T_BC());
    return uncertainty_.OfSmoother(
        stamp, pose, RotatedInformation(camera.covariance, camera.T_WC.R().transpose()));
  }
  const PoseUncertainty of_image = uncertainty_.OfImage(
      stamp, pose,
      {.information_C = RotatedInformation(tracked.information, tracked.T_WC.R().transpose()),
       .error = tracked.error,
       .observers = MeanObservers(map_, tracked)});
  const double delay = ToSeconds(result.stamp - stamp);
  return delay > 0.0 ? UncertaintyEstimator::Predicted(of_image, delay) : of_image;
}

cv::Mat SlamSystem::Impl::ToImage(const cv::Mat& moving) const {
  return moving.empty() ? cv::Mat() : builder_.depth_grid().ToImage(WithBorder(moving));
}

cv::Mat SlamSystem::Impl::DynamicMaskOf(KeyFrameId keyframe) const {
  const KeyFrame* seen = map_.keyframe(keyframe);
  if (seen == nullptr) return {};
  return ToImage(tracker_.DynamicMaskOf(*seen, map_));
}

void SlamSystem::Impl::FollowSharpness(const FrameFeatures& features) {
  usual_sharpness_ +=
      (usual_sharpness_ > 0.0 ? 0.05 : 1.0) * (features.sharpness - usual_sharpness_);
}

bool SlamSystem::Impl::Postpones(const TrackedFrame& tracked, double since_keyframe) {
  return !mapper_.IsIdle() && !mapper_.HasResult() &&
         backlog_.PostponesKeyframe(!options_.mapper.wait,
                                    Support(tracked.num_points, tracked.num_lines), since_keyframe,
                                    options_.keyframes);
}

bool SlamSystem::Impl::WantsKeyFrame(const TrackedFrame& tracked) {
  if (!HasPose(tracked.state)) return false;
  const bool is_first = tracked.state == TrackingState::kTracking && submap_keyframes_ == 0;
  if (is_first) return true;
  const double since_image = tracked.state == TrackingState::kTracking
                                 ? 0.0
                                 : ToSeconds(tracked.frame.stamp - last_visual_);
  const double since_keyframe = clock_.Seconds(last_keyframe_stamp_, tracked.frame.stamp);
  const bool wanted = policy_->Wants({.frame = tracked.frame,
                                      .state = tracked.state,
                                      .T_WC = tracked.T_WC,
                                      .submap = tracked.submap,
                                      .reference = tracked.reference,
                                      .points = tracked.points,
                                      .lines = tracked.lines,
                                      .num_points = tracked.num_points,
                                      .num_lines = tracked.num_lines,
                                      .since_keyframe = since_keyframe,
                                      .since_image = since_image,
                                      .with_imu = inertial_.has_value()},
                                     map_);
  return wanted && !Postpones(tracked, since_keyframe);
}

void SlamSystem::Impl::InsertKeyFrame(TrackedFrame& tracked, FrameResult& result) {
  const StageTimer timer(profile_, "keyframe insertion", &result.times.mapping);
  // The frame belongs to the map as the previous adjustment leaves it.
  const Pose T_new_old = WithTracker([&] {
    const StageTimer waiting(profile_, "end of the local adjustment");
    if (auto report = mapper_.Finish(&map_)) result.adjustment = std::move(report);
  });
  tracked.T_WC = T_new_old * tracked.T_WC;
  const Pose T_WC = tracked.T_WC;
  sensor_.CompensateAround(tracked, options_.mapper.adjusted_keyframes, &map_);
  if (map_.keyframe(last_keyframe_) != nullptr) {
    sensor_.LearnNoise(WithNeighbours(map_, last_keyframe_, kSharedByPlace, kLearnedFrom),
                       last_given_keyframe_, &map_);
  }
  tracked.state = TrackingState::kTracking;
  ++submap_keyframes_;
  result.mapping =
      mapper_.InsertKeyFrame(tracked, map_, MotionSince(map_.keyframe(last_keyframe_)));
  if (result.mapping->bundle.usable) result.adjustment = result.mapping->bundle;
  last_keyframe_stamp_ = last_visual_ = tracked.frame.stamp;
  const KeyFrame& keyframe = *map_.keyframe(result.mapping->keyframe);
  last_keyframe_ = keyframe.id;
  uncertainty_.AddKeyFrame(keyframe.id, &map_);
  imu_constrained_time_ = weighed_ = 0.0;
  tracked.T_WC = keyframe.T_WC;
  tracked.reference = keyframe.id;
  tracked.by_image = false;
  tracker_.Anchor(tracked, keyframe);
  sensor_.Remember(keyframe, tracker_.moved_by());
  if (inertial_) inertial_->MoveMap(keyframe.T_WC * T_WC.Inverse());
}

void SlamSystem::Impl::LookForLoop(FrameResult& result) {
  if (map_.keyframe(last_keyframe_) == nullptr || backlog_.SkipsLoopSearch()) return;
  const StageTimer timer(profile_, "loop search", &result.times.loops);
  const auto prepare = [&] {
    if (options_.tracker.timing == FrameTimingMode::kIgnored) return;
    // The adjustment in progress uses the old row times.
    EditWorld(result, [] {});
    sensor_.CompensateAll(&map_);
  };
  if (loop_closer_.InsertKeyFrame(map_, last_keyframe_, prepare)) {
    worker_.Preempt(loop_closer_);
    ApplyResults(result);
  }
  for (LoopReport& refused : loop_closer_.TakeRefused()) result.loops.push_back(std::move(refused));
}

void SlamSystem::Impl::AdjustToFactors(TrackedFrame& tracked, FrameResult& result) {
  const StageTimer timer(profile_, "user factors", &result.times.loops);
  if (worker_.IsFree()) factor_adjuster_.Begin(map_, submap_, loop_closer_.loops());
  if (!factor_adjuster_.HasResult()) return;
  EditWorld(result, [&] { result.factors = factor_adjuster_.Finish(&map_); });
  tracked.T_WC = map_.keyframe(last_keyframe_)->T_WC;
}

template <class Change>
void SlamSystem::Impl::EditWorld(FrameResult& result, const Change& change) {
  WithTracker([&] {
    if (auto report = worker_.Edit(&map_, change)) result.adjustment = std::move(report);
  });
}

void SlamSystem::Impl::ApplyResults(FrameResult& result) {
  if (!loop_closer_.HasResult()) {
    if (!mapper_.HasResult()) return;
    WithTracker([&] { result.adjustment = mapper_.Update(&map_); });
    return;
  }
  EditWorld(result, [&] {
    for (LoopReport& report : loop_closer_.Update(&map_)) {
      result.loops.push_back(std::move(report));
    }
    factor_adjuster_.Remember(map_, loop_closer_.TakeMovesByFactors());
  });
}

std::vector<MemoryShare> SlamSystem::Impl::memory() const {
  std::vector<MemoryShare> shares = MemoryOf(map_);
  shares.push_back({"poses of frames", tracked_.MemoryBytes()});
  shares.push_back({"frames to be refined", refiner_.MemoryBytes()});
  shares.push_back({"lost frames", lost_frames_.MemoryBytes()});
  shares.push_back({"keyframes to be mapped", release_.MemoryBytes()});
  return shares;
}

Trajectory SlamSystem::Impl::trajectory() const {
  std::vector<SubmapTrajectory> all = submaps();
  return all.empty() ? Trajectory() : std::move(all.front().frames);
}

std::vector<FrameVelocity> SlamSystem::Impl::velocities() const {
  std::vector<SubmapTrajectory> all = submaps();
  return all.empty() ? std::vector<FrameVelocity>() : std::move(all.front().velocities);
}

Trajectory SlamSystem::Impl::keyframe_trajectory() const {
  Trajectory trajectory;
  const std::optional<SubmapId> largest = tracked_.LargestWorld(map_);
  if (!largest) return trajectory;
  for (const KeyFrameId id : map_.KeyFramesOf(*largest)) {
    if (id <= last_given_keyframe_) continue;
    trajectory.push_back({map_.keyframe(id)->frame.stamp, map_.keyframe(id)->T_WC});
  }
  return trajectory;
}

}  // namespace highwall
