#include "tracking/whole_image_source.h"

#include <cstddef>
#include <vector>

#include "map/covisibility.h"
#include "pose/degeneracy.h"
#include "tracking/dynamic_objects.h"
#include "tracking/landmark_observations.h"

namespace highwall {
namespace {

// known: in W, with its information along the axes of W.
ImageMotion MotionFrom(const KeyFrame& reference, const PoseConstraint& known) {
  ImageMotion motion{reference.id, reference.T_WC.Inverse() * known.T_WC, known.sqrt_information};
  motion.sqrt_information.leftCols<3>() *= known.T_WC.R();
  return motion;
}

}  // namespace

WholeImageSource::WholeImageSource(const MapMatcher& matcher, const TrackerOptions& options,
                                   const TrackerParameters& parameters, const DepthGrid& grid,
                                   const FrameSolver& solver, const TrackerState& state)
    : matcher_(matcher),
      options_(options),
      aligner_(grid, matcher.model().depth_noise(), parameters.min_correlation),
      solver_(solver),
      state_(state) {}

bool WholeImageSource::IsDue(const TrackingQuery& query, const PoseSearch& so_far) const {
  // The whole image determines the pose only if most of it is static.
  constexpr double kMost = 0.5;
  // Fewer landmarks than this, and a smaller share of those in view, hold a pose worse than the
  // grey levels of the whole image do. A map of few landmarks that are found, as of lines alone,
  // holds it.
  constexpr int kFew = 130;
  constexpr double kSmallShare = 0.2;
  const auto& best = so_far.best;
  const bool scarce = !best || (best->Support() < kFew && best->frame.found < kSmallShare);
  return scarce && state_.last && query.prediction == nullptr &&
         so_far.diagnostics.masked_share < kMost && options_.direct.enabled;
}

PoseHypothesis WholeImageSource::Propose(const TrackingQuery& query) const {
  PoseHypothesis hypothesis{.origin = PoseOrigin::kImage};
  const KeyFrame* reference = query.map.keyframe(state_.last->reference);
  // Each such pose depends on the one before, or on a view that is left behind.
  const double held = ToSeconds(query.frame.stamp - state_.last_landmarks);
  if (reference == nullptr || held > ConstantVelocity::kLongestPrediction) return hypothesis;
  auto aligned = AlignWith(*reference, query.frame);
  // The last frame is no keyframe, and its own error is not part of the information.
  const bool sees_keyframe = aligned.has_value();
  if (!aligned) aligned = AlignWithLast(query.frame);
  if (!aligned) return hypothesis;
  const PoseConstraint& known = aligned->pose;
  hypothesis.prior = known;
  hypothesis.correlation = aligned->correlation;
  std::optional<ImageMotion> motion;
  if (sees_keyframe) motion = MotionFrom(*reference, known);
  hypothesis.rough = MatchLandmarks(query.With(&known));
  if (hypothesis.rough) hypothesis.rough->image_motion = motion;
  TrackedFrame& bare = hypothesis.without_landmarks.emplace(Unmatched(query.frame, known.T_WC));
  bare.image_motion = motion;
  bare.reference = reference->id;
  bare.information = known.sqrt_information.transpose() * known.sqrt_information;
  bare.open =
      FindUnobservableDirections(bare.information, known.T_WC, aligned->depth, options_.degeneracy);
  return hypothesis;
}

std::optional<DirectAlignment> WholeImageSource::AlignWith(const KeyFrame& reference,
                                                           const Frame& frame) const {
  return aligner_.Align(*reference.frame.features, reference.depth_grid, reference.T_WC,
                        *frame.features, state_.Extrapolate(frame));
}

std::optional<DirectAlignment> WholeImageSource::AlignWithLast(const Frame& frame) const {
  const TrackedFrame& last = *state_.last;
  const FrameFeatures& features = *last.frame.features;
  return aligner_.Align(features, Standing(features.depth_grid, last.moving), last.T_WC,
                        *frame.features, state_.Extrapolate(frame));
}

std::optional<TrackedFrame> WholeImageSource::MatchLandmarks(const TrackingQuery& query) const {
  const FrameFeatures& features = *query.frame.features;
  const Pose& T_WC = query.prediction->T_WC;
  const std::vector<KeyFrameId> local =
      state_.AroundReference(query.map, static_cast<std::size_t>(options_.local_keyframes));
  TrackedFrame rough = Unmatched(query.frame, T_WC);
  ForEachKind([&]<class Landmark>() {
    LandmarkIds<Landmark>& landmarks = PartOf<Landmark>(rough);
    Apply(matcher_.Match(features, T_WC, query.map, query.map.SeenBy<Landmark>(local),
                         Taken(landmarks)),
          landmarks);
  });
  if (!solver_.Solve(query, kMinPredictedSupport, FallbackConstraint::kNone, &rough)) {
    return std::nullopt;
  }
  return rough;
}

}  // namespace highwall
