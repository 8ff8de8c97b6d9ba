#include <highwall/frontend/loops/options.h>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {

void KeyFrameGraphOptions::Validate() const {
  RequirePositive(drift_translation, "KeyFrameGraphOptions::drift_translation");
  RequirePositive(drift_rotation, "KeyFrameGraphOptions::drift_rotation");
  RequirePositive(step_translation, "KeyFrameGraphOptions::step_translation");
  RequirePositive(step_rotation, "KeyFrameGraphOptions::step_rotation");
  RequireNotNegative(drift_bias, "KeyFrameGraphOptions::drift_bias");
  RequirePositive(loop_translation, "KeyFrameGraphOptions::loop_translation");
  RequirePositive(loop_rotation, "KeyFrameGraphOptions::loop_rotation");
  RequirePositive(max_loop_chi2, "KeyFrameGraphOptions::max_loop_chi2");
  RequireAtLeast(min_shared, 1, "KeyFrameGraphOptions::min_shared");
  RequireNotNegative(neighbours, "KeyFrameGraphOptions::neighbours");
}

void LoopDetectorOptions::Validate() const {
  RequireAtLeast(candidates, 1, "LoopDetectorOptions::candidates");
  RequireAtLeast(consistency, 1, "LoopDetectorOptions::consistency");
  RequireAtLeast(min_support, 6, "LoopDetectorOptions::min_support");
  HIGHWALL_REQUIRE(min_found >= 0.0 && min_found <= 1.0,
                   "LoopDetectorOptions::min_found must be in [0, 1]");
  HIGHWALL_REQUIRE(min_found_apart >= 0.0 && min_found_apart <= 1.0,
                   "LoopDetectorOptions::min_found_apart must be in [0, 1]");
  HIGHWALL_REQUIRE(overwhelming >= 1.0, "LoopDetectorOptions::overwhelming must be at least 1");
}

void LoopCorrectionOptions::Validate() const {
  RequireNotNegative(fused_keyframes, "LoopCorrectionOptions::fused_keyframes");
  RequireAtLeast(threads, 1, "LoopCorrectionOptions::threads");
}

void LoopCloserOptions::Validate() const {
  graph.Validate();
  detector.Validate();
  correction.Validate();
  bundle.Validate();
}

void OwnFactorOptions::Validate() const {
  RequireAtLeast(every, 1, "OwnFactorOptions::every");
  RequireNotNegative(share, "OwnFactorOptions::share");
  RequirePositive(max_angle, "OwnFactorOptions::max_angle");
  RequirePositive(max_gap, "OwnFactorOptions::max_gap");
  RequireAtLeast(threads, 1, "OwnFactorOptions::threads");
}

}  // namespace highwall
