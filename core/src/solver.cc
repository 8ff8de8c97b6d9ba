#include <highwall/core/solver.h>

#include <cmath>

#include <highwall/core/error.h>

namespace highwall {

void SolveOptions::Validate() const {
  HIGHWALL_REQUIRE(max_iterations >= 0, "SolveOptions::max_iterations must not be negative, is " +
                                            std::to_string(max_iterations));
  HIGHWALL_REQUIRE(threads >= 1,
                   "SolveOptions::threads must be at least 1, is " + std::to_string(threads));
  HIGHWALL_REQUIRE(max_seconds > 0.0,
                   "SolveOptions::max_seconds must be positive, is " + std::to_string(max_seconds));
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
