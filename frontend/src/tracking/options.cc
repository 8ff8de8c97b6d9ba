#include <highwall/frontend/tracking/options.h>

#include <highwall/core/error.h>

namespace highwall {

void RelocalizerOptions::Validate() const {
  HIGHWALL_REQUIRE(candidates >= 1, "RelocalizerOptions::candidates must be at least 1");
  HIGHWALL_REQUIRE(max_hamming >= 0 && max_hamming <= 256,
                   "RelocalizerOptions::max_hamming must be in [0, 256]");
  HIGHWALL_REQUIRE(ratio > 0.0 && ratio <= 1.0, "RelocalizerOptions::ratio must be in (0, 1]");
  HIGHWALL_REQUIRE(min_matches >= 3, "RelocalizerOptions::min_matches must be at least 3");
  HIGHWALL_REQUIRE(min_inliers >= 6, "RelocalizerOptions::min_inliers must be at least 6");
  HIGHWALL_REQUIRE(min_line_inliers >= 4,
                   "RelocalizerOptions::min_line_inliers must be at least 4");
  HIGHWALL_REQUIRE(ransac_iterations >= 1,
                   "RelocalizerOptions::ransac_iterations must be at least 1");
}

void MovingObjectOptions::Validate() const {
  HIGHWALL_REQUIRE(sigmas > 0.0, "MovingObjectOptions::sigmas must be positive");
  HIGHWALL_REQUIRE(relative >= 0.0, "MovingObjectOptions::relative must not be negative");
  HIGHWALL_REQUIRE(link > 0.0, "MovingObjectOptions::link must be positive");
  HIGHWALL_REQUIRE(min_core >= 1, "MovingObjectOptions::min_core must be at least 1");
  HIGHWALL_REQUIRE(max_share > 0.0 && max_share <= 1.0,
                   "MovingObjectOptions::max_share must be in (0, 1]");
  HIGHWALL_REQUIRE(min_votes >= 1, "MovingObjectOptions::min_votes must be at least 1");
  HIGHWALL_REQUIRE(settled > 0.0, "MovingObjectOptions::settled must be positive");
  HIGHWALL_REQUIRE(interval > 0.0, "MovingObjectOptions::interval must be positive");
  HIGHWALL_REQUIRE(history > interval, "MovingObjectOptions::history must exceed interval");
  HIGHWALL_REQUIRE(min_surface >= 1, "MovingObjectOptions::min_surface must be at least 1");
  HIGHWALL_REQUIRE(max_surface > 0.0 && max_surface <= 1.0,
                   "MovingObjectOptions::max_surface must be in (0, 1]");
  landmarks.Validate();
}

void SurfaceTrackingOptions::Validate() const {
  matcher.Validate();
  HIGHWALL_REQUIRE(min_support >= 3, "SurfaceTrackingOptions::min_support must be at least 3");
  HIGHWALL_REQUIRE(min_rows >= 1, "SurfaceTrackingOptions::min_rows must be at least 1");
  HIGHWALL_REQUIRE(max_sigma > 0.0, "SurfaceTrackingOptions::max_sigma must be positive");
}

void TrackerOptions::Validate() const {
  pose.Validate();
  relocalizer.Validate();
  moving.Validate();
  degeneracy.Validate();
  surfaces.Validate();
  HIGHWALL_REQUIRE(min_motion_support >= 6,
                   "TrackerOptions::min_motion_support must be at least 6");
  HIGHWALL_REQUIRE(min_support >= 6, "TrackerOptions::min_support must be at least 6");
  HIGHWALL_REQUIRE(min_predicted_support >= 6,
                   "TrackerOptions::min_predicted_support must be at least 6");
  HIGHWALL_REQUIRE(doubtful_agreement >= 0.0 && doubtful_agreement <= 1.0,
                   "TrackerOptions::doubtful_agreement must be in [0, 1]");
  HIGHWALL_REQUIRE(doubtful_share >= 0.0 && doubtful_share <= 1.0,
                   "TrackerOptions::doubtful_share must be in [0, 1]");
  HIGHWALL_REQUIRE(doubtful_drop >= 0.0 && doubtful_drop <= 1.0,
                   "TrackerOptions::doubtful_drop must be in [0, 1]");
  HIGHWALL_REQUIRE(local_keyframes >= 1, "TrackerOptions::local_keyframes must be at least 1");
}

void KeyFramePolicyOptions::Validate() const {
  HIGHWALL_REQUIRE(min_features >= 6, "KeyFramePolicyOptions::min_features must be at least 6");
  HIGHWALL_REQUIRE(min_share > 0.0 && min_share <= 1.0,
                   "KeyFramePolicyOptions::min_share must be in (0, 1]");
  HIGHWALL_REQUIRE(max_gap >= 1, "KeyFramePolicyOptions::max_gap must be at least 1");
  HIGHWALL_REQUIRE(wanted_tracked >= 0 && wanted_new >= 0,
                   "KeyFramePolicyOptions::wanted_tracked and wanted_new must not be negative");
}

}  // namespace highwall
