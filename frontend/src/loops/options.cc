#include <highwall/frontend/loops/options.h>

#include <highwall/core/error.h>

namespace highwall {

void KeyFrameGraphOptions::Validate() const {
  HIGHWALL_REQUIRE(drift_translation > 0.0 && drift_rotation > 0.0,
                   "KeyFrameGraphOptions::drift_translation and drift_rotation must be positive");
  HIGHWALL_REQUIRE(step_translation > 0.0 && step_rotation > 0.0,
                   "KeyFrameGraphOptions::step_translation and step_rotation must be positive");
  HIGHWALL_REQUIRE(drift_bias >= 0.0, "KeyFrameGraphOptions::drift_bias must not be negative");
  HIGHWALL_REQUIRE(loop_translation > 0.0 && loop_rotation > 0.0,
                   "KeyFrameGraphOptions::loop_translation and loop_rotation must be positive");
  HIGHWALL_REQUIRE(max_loop_chi2 > 0.0, "KeyFrameGraphOptions::max_loop_chi2 must be positive");
  HIGHWALL_REQUIRE(min_shared >= 1, "KeyFrameGraphOptions::min_shared must be at least 1");
  HIGHWALL_REQUIRE(neighbours >= 0, "KeyFrameGraphOptions::neighbours must not be negative");
}

void LoopDetectorOptions::Validate() const {
  HIGHWALL_REQUIRE(min_shared >= 1, "LoopDetectorOptions::min_shared must be at least 1");
  HIGHWALL_REQUIRE(candidates >= 1, "LoopDetectorOptions::candidates must be at least 1");
  HIGHWALL_REQUIRE(min_score >= 0.0 && min_score <= 1.0,
                   "LoopDetectorOptions::min_score must be in [0, 1]");
  HIGHWALL_REQUIRE(score_share >= 0.0 && score_share <= 1.0,
                   "LoopDetectorOptions::score_share must be in [0, 1]");
  HIGHWALL_REQUIRE(consistency >= 1, "LoopDetectorOptions::consistency must be at least 1");
  verification.Validate();
  HIGHWALL_REQUIRE(place_keyframes >= 0,
                   "LoopDetectorOptions::place_keyframes must not be negative");
  HIGHWALL_REQUIRE(min_support >= 6, "LoopDetectorOptions::min_support must be at least 6");
  HIGHWALL_REQUIRE(min_found >= 0.0 && min_found <= 1.0,
                   "LoopDetectorOptions::min_found must be in [0, 1]");
}

void LoopCorrectionOptions::Validate() const {
  HIGHWALL_REQUIRE(fused_keyframes >= 0,
                   "LoopCorrectionOptions::fused_keyframes must not be negative");
  HIGHWALL_REQUIRE(threads >= 1, "LoopCorrectionOptions::threads must be at least 1");
}

void LoopCloserOptions::Validate() const {
  graph.Validate();
  detector.Validate();
  correction.Validate();
  bundle.Validate();
}

}  // namespace highwall
