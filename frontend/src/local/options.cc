#include <highwall/frontend/local/options.h>

#include <cmath>

#include <highwall/core/error.h>

namespace highwall {

void BundleAdjustmentOptions::Validate() const {
  HIGHWALL_REQUIRE(point_huber > 0.0, "BundleAdjustmentOptions::point_huber must be positive");
  HIGHWALL_REQUIRE(line_huber > 0.0, "BundleAdjustmentOptions::line_huber must be positive");
  inliers.Validate();
  HIGHWALL_REQUIRE(first_iterations >= 1 && second_iterations >= 1,
                   "BundleAdjustmentOptions: iterations must be at least 1");
  HIGHWALL_REQUIRE(tolerance >= 0.0 && std::isfinite(tolerance),
                   "BundleAdjustmentOptions::tolerance must be finite, not negative");
  HIGHWALL_REQUIRE(trust_region > 0.0 && std::isfinite(trust_region),
                   "BundleAdjustmentOptions::trust_region must be positive and finite");
  HIGHWALL_REQUIRE(threads >= 1, "BundleAdjustmentOptions::threads must be at least 1");
}

void LocalMapperOptions::Validate() const {
  bundle.Validate();
  HIGHWALL_REQUIRE(adjusted_keyframes >= 2,
                   "LocalMapperOptions::adjusted_keyframes must be at least 2");
  HIGHWALL_REQUIRE(fixed_keyframes >= 1, "LocalMapperOptions::fixed_keyframes must be at least 1");
  HIGHWALL_REQUIRE(fused_keyframes >= 0,
                   "LocalMapperOptions::fused_keyframes must not be negative");
  HIGHWALL_REQUIRE(min_found_ratio >= 0.0 && min_found_ratio <= 1.0,
                   "LocalMapperOptions::min_found_ratio must be in [0, 1]");
  HIGHWALL_REQUIRE(probation_keyframes >= 1,
                   "LocalMapperOptions::probation_keyframes must be at least 1");
  HIGHWALL_REQUIRE(min_observations >= 1,
                   "LocalMapperOptions::min_observations must be at least 1");
  HIGHWALL_REQUIRE(redundant_share > 0.0 && redundant_share <= 1.0,
                   "LocalMapperOptions::redundant_share must be in (0, 1]");
  HIGHWALL_REQUIRE(redundant_observers >= 1,
                   "LocalMapperOptions::redundant_observers must be at least 1");
  HIGHWALL_REQUIRE(max_motion_gap > 0.0, "LocalMapperOptions::max_motion_gap must be positive");
  HIGHWALL_REQUIRE(motion_span >= 0.0, "LocalMapperOptions::motion_span must not be negative");
  HIGHWALL_REQUIRE(max_depth_sigma > 0.0, "LocalMapperOptions::max_depth_sigma must be positive");
  HIGHWALL_REQUIRE(min_line_length > 0.0, "LocalMapperOptions::min_line_length must be positive");
}

}  // namespace highwall
