#include <highwall/frontend/map/options.h>

#include <highwall/core/error.h>

namespace highwall {

void MeasurementOptions::Validate() const {
  HIGHWALL_REQUIRE(baseline > 0.0, "MeasurementOptions::baseline must be positive");
  HIGHWALL_REQUIRE(point_sigma > 0.0, "MeasurementOptions::point_sigma must be positive");
  HIGHWALL_REQUIRE(line_sigma > 0.0, "MeasurementOptions::line_sigma must be positive");
  search.Validate();
  line_matches.Validate();
}

void ProjectionMatchOptions::Validate() const {
  HIGHWALL_REQUIRE(max_hamming >= 0 && max_hamming <= 256,
                   "ProjectionMatchOptions::max_hamming must be in [0, 256]");
  HIGHWALL_REQUIRE(ratio > 0.0 && ratio <= 1.0, "ProjectionMatchOptions::ratio must be in (0, 1]");
  HIGHWALL_REQUIRE(max_angle_diff > 0.0, "ProjectionMatchOptions::max_angle_diff must be positive");
}

void MapMatcherOptions::Validate() const {
  HIGHWALL_REQUIRE(motion_radius > 0.0, "MapMatcherOptions::motion_radius must be positive");
  HIGHWALL_REQUIRE(map_radius > 0.0, "MapMatcherOptions::map_radius must be positive");
  HIGHWALL_REQUIRE(min_view_cosine >= -1.0 && min_view_cosine <= 1.0,
                   "MapMatcherOptions::min_view_cosine must be in [-1, 1]");
  motion_match.Validate();
  map_match.Validate();
  HIGHWALL_REQUIRE(min_line_pixels >= 1.0F,
                   "MapMatcherOptions::min_line_pixels must be at least 1");
}

void KeyFrameIndexOptions::Validate() const {
  HIGHWALL_REQUIRE(tables >= 1 && tables <= 12, "KeyFrameIndexOptions::tables must be in [1, 12]");
  HIGHWALL_REQUIRE(max_signature_bits >= 0 && max_signature_bits <= 32,
                   "KeyFrameIndexOptions::max_signature_bits must be in [0, 32]");
  HIGHWALL_REQUIRE(line_weight >= 0.0, "KeyFrameIndexOptions::line_weight must not be negative");
}

}  // namespace highwall
