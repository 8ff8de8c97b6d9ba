#include <highwall/frontend/pose/options.h>

#include <cmath>

#include <highwall/core/error.h>

namespace highwall {

void PoseSolverOptions::Validate() const {
  HIGHWALL_REQUIRE(point_huber > 0.0, "PoseSolverOptions::point_huber must be positive");
  HIGHWALL_REQUIRE(line_huber > 0.0, "PoseSolverOptions::line_huber must be positive");
  HIGHWALL_REQUIRE(plane_huber > 0.0, "PoseSolverOptions::plane_huber must be positive");
  inliers.Validate();
  HIGHWALL_REQUIRE(rounds >= 1, "PoseSolverOptions::rounds must be at least 1");
  HIGHWALL_REQUIRE(max_iterations >= 1, "PoseSolverOptions::max_iterations must be at least 1");
  HIGHWALL_REQUIRE(min_support >= 3, "PoseSolverOptions::min_support must be at least 3");
}

void DegeneracyOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(max_sigma) && max_sigma > 0.0,
                   "DegeneracyOptions::max_sigma must be positive");
}

void SurfaceMatcherOptions::Validate() const {
  HIGHWALL_REQUIRE(stride >= 1, "SurfaceMatcherOptions::stride must be at least 1");
  HIGHWALL_REQUIRE(radius >= 1, "SurfaceMatcherOptions::radius must be at least 1");
  HIGHWALL_REQUIRE(link > 0.0, "SurfaceMatcherOptions::link must be positive");
  HIGHWALL_REQUIRE(min_share > 0.0 && min_share <= 1.0,
                   "SurfaceMatcherOptions::min_share must be in (0, 1]");
  HIGHWALL_REQUIRE(planar_sigmas > 0.0, "SurfaceMatcherOptions::planar_sigmas must be positive");
  HIGHWALL_REQUIRE(roughness >= 0.0, "SurfaceMatcherOptions::roughness must not be negative");
  HIGHWALL_REQUIRE(max_incidence > 0.0 && max_incidence < 0.5 * std::numbers::pi,
                   "SurfaceMatcherOptions::max_incidence must be in (0, pi/2)");
  HIGHWALL_REQUIRE(max_tilt > 0.0, "SurfaceMatcherOptions::max_tilt must be positive");
  HIGHWALL_REQUIRE(gate_sigmas > 0.0, "SurfaceMatcherOptions::gate_sigmas must be positive");
  HIGHWALL_REQUIRE(gate >= 0.0, "SurfaceMatcherOptions::gate must not be negative");
  HIGHWALL_REQUIRE(max_rows >= 1, "SurfaceMatcherOptions::max_rows must be at least 1");
}

void LandmarkMotionOptions::Validate() const {
  HIGHWALL_REQUIRE(min_points >= 1, "LandmarkMotionOptions::min_points must be at least 1");
  HIGHWALL_REQUIRE(min_share > 0.0 && min_share <= 1.0,
                   "LandmarkMotionOptions::min_share must be in (0, 1]");
  HIGHWALL_REQUIRE(chi2 > 0.0, "LandmarkMotionOptions::chi2 must be positive");
  HIGHWALL_REQUIRE(min_support >= 6, "LandmarkMotionOptions::min_support must be at least 6");
  HIGHWALL_REQUIRE(outnumber > 0.0, "LandmarkMotionOptions::outnumber must be positive");
}

}  // namespace highwall
