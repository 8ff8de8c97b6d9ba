#include <highwall/frontend/local/options.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {

void BundleAdjustmentOptions::Validate() const {
  RequirePositive(point_huber, "BundleAdjustmentOptions::point_huber");
  RequirePositive(line_huber, "BundleAdjustmentOptions::line_huber");
  inliers.Validate();
  RequireAtLeast(first_iterations, 1, "BundleAdjustmentOptions::first_iterations");
  RequireAtLeast(second_iterations, 1, "BundleAdjustmentOptions::second_iterations");
  HIGHWALL_REQUIRE(tolerance >= 0.0 && std::isfinite(tolerance),
                   "BundleAdjustmentOptions::tolerance must be finite, not negative");
  HIGHWALL_REQUIRE(trust_region > 0.0 && std::isfinite(trust_region),
                   "BundleAdjustmentOptions::trust_region must be positive and finite");
  RequireAtLeast(threads, 1, "BundleAdjustmentOptions::threads");
}

void TriangulationOptions::Validate() const {
  RequireNotNegative(keyframes, "TriangulationOptions::keyframes");
  RequireAtLeast(min_views, 2, "TriangulationOptions::min_views");
  RequireNotNegative(scarce_points, "TriangulationOptions::scarce_points");
  RequirePositive(max_depth_sigma, "TriangulationOptions::max_depth_sigma");
  HIGHWALL_REQUIRE(max_hamming >= 0 && max_hamming <= 256,
                   "TriangulationOptions::max_hamming must be in [0, 256]");
  HIGHWALL_REQUIRE(ratio > 0.0 && ratio <= 1.0, "TriangulationOptions::ratio must be in (0, 1]");
}

void LocalMapperOptions::Validate() const {
  bundle.Validate();
  RequireAtLeast(adjusted_keyframes, 2, "LocalMapperOptions::adjusted_keyframes");
  RequireAtLeast(fixed_keyframes, 1, "LocalMapperOptions::fixed_keyframes");
  RequireNotNegative(fused_keyframes, "LocalMapperOptions::fused_keyframes");
  HIGHWALL_REQUIRE(min_found_ratio >= 0.0 && min_found_ratio <= 1.0,
                   "LocalMapperOptions::min_found_ratio must be in [0, 1]");
  RequireAtLeast(probation_keyframes, 1, "LocalMapperOptions::probation_keyframes");
  RequireAtLeast(min_observations, 1, "LocalMapperOptions::min_observations");
  HIGHWALL_REQUIRE(redundant_share > 0.0 && redundant_share <= 1.0,
                   "LocalMapperOptions::redundant_share must be in (0, 1]");
  RequireAtLeast(redundant_observers, 1, "LocalMapperOptions::redundant_observers");
  RequirePositive(max_motion_gap, "LocalMapperOptions::max_motion_gap");
  RequireNotNegative(motion_span, "LocalMapperOptions::motion_span");
  RequirePositive(max_depth_sigma, "LocalMapperOptions::max_depth_sigma");
  RequirePositive(min_line_length, "LocalMapperOptions::min_line_length");
  triangulation.Validate();
}

}  // namespace highwall
