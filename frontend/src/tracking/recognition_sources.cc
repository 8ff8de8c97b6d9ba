#include "tracking/recognition_sources.h"

#include <optional>

#include "tracking/landmark_observations.h"

namespace highwall {
namespace {

// Returns a frame with the relocalizer's matches.
TrackedFrame Matched(const Frame& frame, const Relocalization& found) {
  TrackedFrame tracked = Unmatched(frame, found.T_WC);
  ForEachKind(
      [&]<class Landmark>() { Apply(PartOf<Landmark>(found.matches), PartOf<Landmark>(tracked)); });
  tracked.tried = tracked;
  return tracked;
}

}  // namespace

bool ReferenceKeyframeSource::IsDue(const TrackingQuery&, const PoseSearch& so_far) const {
  return so_far.is_ambiguous;
}

PoseHypothesis ReferenceKeyframeSource::Propose(const TrackingQuery& query) const {
  PoseHypothesis hypothesis{.origin = PoseOrigin::kReference};
  const TrackedFrame& last = *state_.last;
  if (query.map.keyframe(last.reference) == nullptr) return hypothesis;
  const auto found =
      relocalizer_.MatchKeyFrame(*query.frame.features, query.map, last.reference, last.T_WC);
  if (found) hypothesis.rough = Matched(query.frame, *found);
  return hypothesis;
}

bool PlaceIndexSource::IsDue(const TrackingQuery&, const PoseSearch& so_far) const {
  return !so_far.best;
}

PoseHypothesis PlaceIndexSource::Propose(const TrackingQuery& query) const {
  PoseHypothesis hypothesis{.origin = PoseOrigin::kPlace};
  const auto found = relocalizer_.Relocalize(*query.frame.features, query.map);
  if (!found) return hypothesis;
  hypothesis.rough = Matched(query.frame, *found);
  hypothesis.rough->relocalized = true;
  return hypothesis;
}

}  // namespace highwall
