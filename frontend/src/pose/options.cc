#include <highwall/frontend/pose/options.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {

void PoseSolverOptions::Validate() const {
  RequirePositive(point_huber, "PoseSolverOptions::point_huber");
  RequirePositive(line_huber, "PoseSolverOptions::line_huber");
  RequirePositive(plane_huber, "PoseSolverOptions::plane_huber");
  inliers.Validate();
  RequireAtLeast(rounds, 1, "PoseSolverOptions::rounds");
  RequireAtLeast(max_iterations, 1, "PoseSolverOptions::max_iterations");
  RequireAtLeast(min_support, 3, "PoseSolverOptions::min_support");
}

void DegeneracyOptions::Validate() const {
  RequirePositiveFinite(max_sigma, "DegeneracyOptions::max_sigma");
}

void SurfaceMatcherOptions::Validate() const {
  RequireAtLeast(stride, 1, "SurfaceMatcherOptions::stride");
  RequireAtLeast(radius, 1, "SurfaceMatcherOptions::radius");
  HIGHWALL_REQUIRE(min_share > 0.0 && min_share <= 1.0,
                   "SurfaceMatcherOptions::min_share must be in (0, 1]");
  HIGHWALL_REQUIRE(max_incidence > 0.0 && max_incidence < 0.5 * std::numbers::pi,
                   "SurfaceMatcherOptions::max_incidence must be in (0, pi/2)");
  RequirePositive(max_tilt, "SurfaceMatcherOptions::max_tilt");
  RequirePositive(gate_sigmas, "SurfaceMatcherOptions::gate_sigmas");
  RequireNotNegative(gate, "SurfaceMatcherOptions::gate");
}

void DirectAlignmentOptions::Validate() const {
  RequireAtLeast(min_rows, 1, "DirectAlignmentOptions::min_rows");
  HIGHWALL_REQUIRE(min_correlation >= 0.0 && min_correlation < 1.0,
                   "DirectAlignmentOptions::min_correlation must be in [0, 1)");
  RequirePositive(max_sigma, "DirectAlignmentOptions::max_sigma");
}

void LandmarkMotionOptions::Validate() const {
  RequireAtLeast(min_points, 1, "LandmarkMotionOptions::min_points");
  HIGHWALL_REQUIRE(min_share > 0.0 && min_share <= 1.0,
                   "LandmarkMotionOptions::min_share must be in (0, 1]");
  RequirePositive(chi2, "LandmarkMotionOptions::chi2");
  RequireAtLeast(min_support, 6, "LandmarkMotionOptions::min_support");
  RequirePositive(outnumber, "LandmarkMotionOptions::outnumber");
}

}  // namespace highwall
