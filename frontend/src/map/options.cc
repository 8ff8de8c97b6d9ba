#include <highwall/frontend/map/options.h>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {

void MeasurementOptions::Validate() const {
  RequirePositive(baseline, "MeasurementOptions::baseline");
  RequirePositive(point_sigma, "MeasurementOptions::point_sigma");
  RequirePositive(line_sigma, "MeasurementOptions::line_sigma");
  search.Validate();
  line_matches.Validate();
}

void ProjectionMatchOptions::Validate() const {
  HIGHWALL_REQUIRE(max_hamming >= 0 && max_hamming <= 256,
                   "ProjectionMatchOptions::max_hamming must be in [0, 256]");
  HIGHWALL_REQUIRE(ratio > 0.0 && ratio <= 1.0, "ProjectionMatchOptions::ratio must be in (0, 1]");
  RequirePositive(max_angle_diff, "ProjectionMatchOptions::max_angle_diff");
}

void MapMatcherOptions::Validate() const {
  RequirePositive(motion_radius, "MapMatcherOptions::motion_radius");
  RequirePositive(map_radius, "MapMatcherOptions::map_radius");
  HIGHWALL_REQUIRE(min_view_cosine >= -1.0 && min_view_cosine <= 1.0,
                   "MapMatcherOptions::min_view_cosine must be in [-1, 1]");
  motion_match.Validate();
  map_match.Validate();
  RequireAtLeast(min_line_pixels, 1.0F, "MapMatcherOptions::min_line_pixels");
}

void KeyFrameIndexOptions::Validate() const {
  HIGHWALL_REQUIRE(tables >= 1 && tables <= 12, "KeyFrameIndexOptions::tables must be in [1, 12]");
  HIGHWALL_REQUIRE(max_signature_bits >= 0 && max_signature_bits <= 32,
                   "KeyFrameIndexOptions::max_signature_bits must be in [0, 32]");
  RequireNotNegative(line_weight, "KeyFrameIndexOptions::line_weight");
}

}  // namespace highwall
