#include <highwall/frontend/tracking/options.h>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {

const char* ToString(FrameTimingMode mode) {
  switch (mode) {
    case FrameTimingMode::kIgnored:
      return "ignored";
    case FrameTimingMode::kKnown:
      return "known";
    case FrameTimingMode::kEstimated:
      break;
  }
  return "estimated";
}

void RelocalizerOptions::Validate() const {
  RequireAtLeast(candidates, 1, "RelocalizerOptions::candidates");
  HIGHWALL_REQUIRE(max_hamming >= 0 && max_hamming <= 256,
                   "RelocalizerOptions::max_hamming must be in [0, 256]");
  HIGHWALL_REQUIRE(ratio > 0.0 && ratio <= 1.0, "RelocalizerOptions::ratio must be in (0, 1]");
  RequireAtLeast(min_matches, 3, "RelocalizerOptions::min_matches");
  RequireAtLeast(min_inliers, 6, "RelocalizerOptions::min_inliers");
  RequireAtLeast(min_line_inliers, 4, "RelocalizerOptions::min_line_inliers");
  RequireAtLeast(ransac_iterations, 1, "RelocalizerOptions::ransac_iterations");
}

void MovingObjectOptions::Validate() const {
  HIGHWALL_REQUIRE(max_share > 0.0 && max_share <= 1.0,
                   "MovingObjectOptions::max_share must be in (0, 1]");
  RequirePositive(settled, "MovingObjectOptions::settled");
  RequirePositive(interval, "MovingObjectOptions::interval");
  HIGHWALL_REQUIRE(history > interval, "MovingObjectOptions::history must exceed interval");
  RequireAtLeast(min_surface, 1, "MovingObjectOptions::min_surface");
  HIGHWALL_REQUIRE(max_surface > 0.0 && max_surface <= 1.0,
                   "MovingObjectOptions::max_surface must be in (0, 1]");
  landmarks.Validate();
}

void SurfaceTrackingOptions::Validate() const {
  matcher.Validate();
  RequireAtLeast(min_support, 3, "SurfaceTrackingOptions::min_support");
  RequireAtLeast(min_rows, 1, "SurfaceTrackingOptions::min_rows");
  RequirePositive(max_sigma, "SurfaceTrackingOptions::max_sigma");
}

void TrackerOptions::Validate() const {
  pose.Validate();
  relocalizer.Validate();
  moving.Validate();
  degeneracy.Validate();
  surfaces.Validate();
  direct.Validate();
  RequireAtLeast(min_motion_support, 6, "TrackerOptions::min_motion_support");
  RequireAtLeast(min_support, 6, "TrackerOptions::min_support");
  RequireAtLeast(min_predicted_support, 6, "TrackerOptions::min_predicted_support");
  HIGHWALL_REQUIRE(doubtful_agreement >= 0.0 && doubtful_agreement <= 1.0,
                   "TrackerOptions::doubtful_agreement must be in [0, 1]");
  HIGHWALL_REQUIRE(doubtful_share >= 0.0 && doubtful_share <= 1.0,
                   "TrackerOptions::doubtful_share must be in [0, 1]");
  HIGHWALL_REQUIRE(doubtful_drop >= 0.0 && doubtful_drop <= 1.0,
                   "TrackerOptions::doubtful_drop must be in [0, 1]");
  HIGHWALL_REQUIRE(recognized_found >= 0.0 && recognized_found <= 1.0,
                   "TrackerOptions::recognized_found must be in [0, 1]");
  HIGHWALL_REQUIRE(recognized_contradiction >= 0.0 && recognized_contradiction <= 1.0,
                   "TrackerOptions::recognized_contradiction must be in [0, 1]");
  RequireAtLeast(local_keyframes, 1, "TrackerOptions::local_keyframes");
}

void KeyFramePolicyOptions::Validate() const {
  RequireAtLeast(min_features, 6, "KeyFramePolicyOptions::min_features");
  HIGHWALL_REQUIRE(min_share > 0.0 && min_share <= 1.0,
                   "KeyFramePolicyOptions::min_share must be in (0, 1]");
  RequirePositive(max_gap, "KeyFramePolicyOptions::max_gap");
  RequireNotNegative(wanted_tracked, "KeyFramePolicyOptions::wanted_tracked");
  RequireNotNegative(wanted_new, "KeyFramePolicyOptions::wanted_new");
}

}  // namespace highwall
