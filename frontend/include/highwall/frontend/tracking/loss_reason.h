#pragma once

namespace highwall {

// Why a frame has no pose.
enum class LossReason {
  kDark,           // too few features: hardly any light
  kBlurred,        // too few features, and less sharp than usual
  kPlain,          // too few features: nothing to be seen
  kNoDepth,        // too few features with depth
  kTooFast,        // at constant velocity the image has shifted by many search windows
  kContradictory,  // most matches with the last frame deny the rest
  kAllMoving,      // most features are on what moves
  kUnknownPlace,   // nothing that the map knows
  kRepeatedImage,  // the colour image is the one before, for too long
  kDeadReckoning,  // nothing that the map knows, for longer than an IMU can bridge
};

// "dark", "blurred", "plain", "no depth", "too fast", "contradictory", "all moving", "unknown
// place", "repeated image" or "dead reckoning".
const char* ToString(LossReason reason);

}  // namespace highwall
