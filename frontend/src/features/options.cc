#include <highwall/frontend/features/options.h>

#include <numbers>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

void ValidateGates(const LineGates& gates) {
  HIGHWALL_REQUIRE(gates.max_angle > 0.0 && gates.max_angle <= std::numbers::pi / 2,
                   "LineGates::max_angle must be in (0, pi/2]");
  HIGHWALL_REQUIRE(gates.min_length_ratio >= 0.0 && gates.min_length_ratio < 1.0,
                   "LineGates::min_length_ratio must be in [0, 1)");
  HIGHWALL_REQUIRE(gates.max_midpoint_distance > 0.0,
                   "LineGates::max_midpoint_distance must be positive");
}

}  // namespace

void PyramidOptions::Validate() const {
  HIGHWALL_REQUIRE(levels >= 1 && levels <= 16, "PyramidOptions::levels must be in [1, 16]");
  HIGHWALL_REQUIRE(scale_factor > 1.0 && scale_factor <= 2.0,
                   "PyramidOptions::scale_factor must be in (1, 2]");
}

void OrbExtractorOptions::Validate() const {
  RequirePositive(features, "OrbExtractorOptions::features");
  pyramid.Validate();
  HIGHWALL_REQUIRE(fast_threshold >= 1 && fast_threshold <= 255,
                   "OrbExtractorOptions::fast_threshold must be in [1, 255]");
  HIGHWALL_REQUIRE(min_fast_threshold >= 1 && min_fast_threshold <= fast_threshold,
                   "OrbExtractorOptions::min_fast_threshold must be in [1, fast_threshold]");
}

void LineExtractorOptions::Validate() const {
  HIGHWALL_REQUIRE(min_length > 0.0 && min_length <= 1.0,
                   "LineExtractorOptions::min_length must be in (0, 1]");
  RequirePositive(max_lines, "LineExtractorOptions::max_lines");
}

void SegmentDepthOptions::Validate() const {
  HIGHWALL_REQUIRE(samples >= 4 && samples <= 64,
                   "SegmentDepthOptions::samples must be in [4, 64]");
  HIGHWALL_REQUIRE(min_valid > 0.0 && min_valid <= 1.0,
                   "SegmentDepthOptions::min_valid must be in (0, 1]");
  HIGHWALL_REQUIRE(min_inliers > 0.0 && min_inliers <= 1.0,
                   "SegmentDepthOptions::min_inliers must be in (0, 1]");
  RequirePositive(ransac_iterations, "SegmentDepthOptions::ransac_iterations");
}

void FrameBuilderOptions::Validate() const {
  orb.Validate();
  lines.Validate();
  segment_depth.Validate();
  HIGHWALL_REQUIRE(use_points || use_lines,
                   "FrameBuilderOptions: use_points and use_lines are both off");
  RequireNotNegative(depth_spread_share, "FrameBuilderOptions::depth_spread_share");
}

void LineMatcherOptions::Validate() const {
  ValidateGates(small_motion);
  ValidateGates(large_motion);
  HIGHWALL_REQUIRE(max_distance >= 0 && max_distance <= 256,
                   "LineMatcherOptions::max_distance must be in [0, 256]");
  HIGHWALL_REQUIRE(ratio > 0.0 && ratio <= 1.0, "LineMatcherOptions::ratio must be in (0, 1]");
  RequirePositive(mad_k, "LineMatcherOptions::mad_k");
  RequireNotNegative(min_deviation, "LineMatcherOptions::min_deviation");
}

const char* ToString(LineDetector detector) {
  return detector == LineDetector::kLsd ? "lsd" : "edlines";
}

const char* ToString(MadRule rule) {
  return rule == MadRule::kMedian ? "median" : "paper";
}

}  // namespace highwall
