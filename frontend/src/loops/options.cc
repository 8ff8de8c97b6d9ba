#include <highwall/frontend/loops/options.h>

#include <highwall/core/error.h>
#include <highwall/internal/require.h>

namespace highwall {

void KeyFrameGraphOptions::Validate() const {
  HIGHWALL_REQUIRE(drift_translation > 0.0 && drift_rotation > 0.0,
                   "KeyFrameGraphOptions::drift_translation and drift_rotation must be positive");
  HIGHWALL_REQUIRE(step_translation > 0.0 && step_rotation > 0.0,
                   "KeyFrameGraphOptions::step_translation and step_rotation must be positive");
  RequireNotNegative(drift_bias, "KeyFrameGraphOptions::drift_bias");
  HIGHWALL_REQUIRE(loop_translation > 0.0 && loop_rotation > 0.0,
                   "KeyFrameGraphOptions::loop_translation and loop_rotation must be positive");
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

}  // namespace highwall
