#include "tracking/last_frame_source.h"

#include <algorithm>
#include <optional>
#include <type_traits>
#include <utility>

#include "features/row_times.h"
#include "tracking/landmark_observations.h"

namespace highwall {

bool LastFrameSource::IsDue(const TrackingQuery&, const PoseSearch&) const {
  return state_.last.has_value();
}

PoseHypothesis LastFrameSource::Propose(const TrackingQuery& query) const {
  return ProposeWith(FallbackConstraint::kNone, query);
}

PoseHypothesis LastFrameSource::ProposeWith(FallbackConstraint fallback,
                                            const TrackingQuery& query) const {
  const auto& [frame, map, prediction] = query;
  PoseHypothesis hypothesis{.fallback = fallback};
  if (prediction != nullptr) hypothesis.prior = *prediction;
  AttemptDiagnostics& diagnostics = hypothesis.diagnostics;
  if (prediction == nullptr) diagnostics.shift = Shift(frame);
  // A landmark may have been removed, and the last frame's reference moved, since it was tracked.
  std::optional<TrackedFrame>& best = hypothesis.rough;
  for (const double radius_scale : {1.0, 2.0}) {
    TrackedFrame tracked =
        Unmatched(frame, prediction != nullptr ? prediction->T_WC : state_.Extrapolate(frame));
    MatchLast(query, radius_scale, &tracked);
    const bool solved = solver_.Solve(query, kMinMotionSupport, fallback, &tracked);
    diagnostics.tried = std::max(diagnostics.tried, MatchedSupport(tracked.tried));
    if (!solved) continue;
    const int agreed = MatchedSupport(tracked);
    diagnostics.agreed = std::max(diagnostics.agreed, agreed);
    hypothesis.is_inconsistent = IsInconsistent(tracked);
    if (!hypothesis.is_inconsistent) {
      best = std::move(tracked);
      break;
    }
    if (!best || agreed > MatchedSupport(*best)) best = std::move(tracked);
  }
  return hypothesis;
}

void LastFrameSource::MatchLast(const TrackingQuery& query, double radius_scale,
                                TrackedFrame* tracked) const {
  const FrameFeatures& features = *query.frame.features;
  const TrackedFrame& last = *state_.last;
  ForEachKind([&]<class Landmark>() {
    LandmarkIds<Landmark>& landmarks = PartOf<Landmark>(*tracked);
    if constexpr (std::is_same_v<Landmark, MapPoint>) {
      Apply(matcher_.MatchLast(features, tracked->T_WC, query.map, *last.frame.features,
                               last.points, radius_scale),
            landmarks);
    } else {
      Apply(matcher_.Match(features, tracked->T_WC, query.map, PartOf<Landmark>(last),
                           Taken(landmarks)),
            landmarks);
    }
  });
}

bool LastFrameSource::IsInconsistent(const TrackedFrame& rough) const {
  return MatchedSupport(rough) < parameters_.doubtful_agreement * MatchedSupport(rough.tried);
}

double LastFrameSource::Shift(const Frame& frame) const {
  const Pose T = state_.velocity.Predict(state_.SinceLast(frame));
  return matcher_.model().camera().fx *
         (T.Angle() + T.p().norm() / MedianDepth(*state_.last->frame.features));
}

bool SurfaceSource::IsDue(const TrackingQuery& query, const PoseSearch& so_far) const {
  return !so_far.best && state().last && query.prediction == nullptr && options().surfaces.enabled;
}

PoseHypothesis SurfaceSource::Propose(const TrackingQuery& query) const {
  PoseHypothesis hypothesis = ProposeWith(FallbackConstraint::kSurfaces, query);
  hypothesis.origin = PoseOrigin::kSurfaces;
  return hypothesis;
}

}  // namespace highwall
