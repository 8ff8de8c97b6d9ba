#pragma once

#include "pose/direct_alignment.h"
#include "tracking/dynamic_objects.h"
#include "tracking/relocalizer.h"

namespace highwall {

// Parameters of Tracker that are no options of a user.
struct TrackerParameters {
  RelocalizerOptions relocalizer{};
  // Of the last frame's reference keyframe: fewer inliers suffice than for any place of the map,
  // since all landmarks around must then confirm the pose.
  RelocalizerOptions reference{.min_inliers = 12};
  DynamicObjectParameters moving{};
  double min_correlation = kMinGreyCorrelation;  // [0, 1): of DirectAligner
  // Repeated patterns can produce a false pose that a few matches support and most are inconsistent
  // with. A pose is ambiguous, as by TrackerOptions::doubtful_share, if its support is below the
  // first share of that of all first matches, or below the second of the last frame's support, both
  // in [0, 1]. If most first matches are inconsistent with a pose, it must have no unobservable
  // direction.
  double doubtful_agreement = 0.33;
  double doubtful_drop = 0.3;
  // A recognized place (found without the motion model) may be a similar one: its share of matched
  // landmarks in view must be at least this fraction of the mean match ratio of frames, and no more
  // than this share of the depth may be inconsistent in either direction (DepthContradiction), both
  // in [0, 1].
  double recognized_found = 0.5;
  double recognized_contradiction = 0.1;
  int recognized_views = 3;  // >= 1: keyframes whose depth is compared
};

}  // namespace highwall
