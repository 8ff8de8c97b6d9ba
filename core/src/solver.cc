#include <highwall/core/solver.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {

void SolveOptions::Validate() const {
  RequireNotNegative(max_iterations, "SolveOptions::max_iterations");
  RequireAtLeast(threads, 1, "SolveOptions::threads");
  RequirePositive(max_seconds, "SolveOptions::max_seconds");
  HIGHWALL_REQUIRE(function_tolerance >= 0.0,
                   "SolveOptions::function_tolerance must not be negative");
  HIGHWALL_REQUIRE(gradient_tolerance >= 0.0,
                   "SolveOptions::gradient_tolerance must not be negative");
  HIGHWALL_REQUIRE(parameter_tolerance >= 0.0,
                   "SolveOptions::parameter_tolerance must not be negative");
  HIGHWALL_REQUIRE(std::isfinite(initial_trust_region_radius) && initial_trust_region_radius > 0.0,
                   "SolveOptions::initial_trust_region_radius must be positive and finite");
}

const char* ToString(SolveStatus status) {
  switch (status) {
    case SolveStatus::kConverged:
      return "converged";
    case SolveStatus::kLimit:
      return "limit";
    case SolveStatus::kStopped:
      return "stopped";
    case SolveStatus::kFailed:
      break;
  }
  return "failed";
}

}  // namespace highwall
