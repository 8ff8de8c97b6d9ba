#include "tracking/last_frame_source.h"

#include <algorithm>
#include <optional>
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
  const TrackedFrame& last = *state_.last;
  PoseHypothesis hypothesis{.fallback = fallback};
  if (prediction != nullptr) hypothesis.prior = *prediction;
  AttemptDiagnostics& diagnostics = hypothesis.diagnostics;
  if (prediction == nullptr) diagnostics.shift = Shift(frame);
  // A landmark may have been removed, and the last frame's reference moved, since it was tracked.
  std::optional<TrackedFrame>& best = hypothesis.rough;
  for (const double radius_scale : {1.0, 2.0}) {
    TrackedFrame tracked =
        Unmatched(frame, prediction != nullptr ? prediction->T_WC : state_.Extrapolate(frame));
    Apply(matcher_.MatchLast(*frame.features, tracked.T_WC, map, *last.frame.features, last.points,
                             radius_scale),
          tracked.points);
    Apply(matcher_.Match(*frame.features, tracked.T_WC, map, last.lines, Taken(tracked.lines)),
          tracked.lines);
    const bool solved = solver_.Solve(query, kMinMotionSupport, fallback, &tracked);
    diagnostics.tried =
        std::max(diagnostics.tried, MatchedSupport(tracked.tried_points, tracked.tried_lines));
    if (!solved) continue;
    const int agreed = MatchedSupport(tracked.points, tracked.lines);
    diagnostics.agreed = std::max(diagnostics.agreed, agreed);
    hypothesis.is_inconsistent = IsInconsistent(tracked);
    if (!hypothesis.is_inconsistent) {
      best = std::move(tracked);
      break;
    }
    if (!best || agreed > MatchedSupport(best->points, best->lines)) best = std::move(tracked);
  }
  return hypothesis;
}

bool LastFrameSource::IsInconsistent(const TrackedFrame& rough) const {
  return MatchedSupport(rough.points, rough.lines) <
         parameters_.doubtful_agreement * MatchedSupport(rough.tried_points, rough.tried_lines);
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
