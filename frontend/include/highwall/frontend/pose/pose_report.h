#pragma once

#include <array>

#include <Eigen/Core>

// Reports on the pose of a frame.
namespace [[gnu::visibility("default")]] highwall {

// Tracking state of a frame.
enum class TrackingState {
  kInitializing,  // no map yet: the first frames had too little depth or texture
  kTracking,
  kInertial,  // the pose is predicted by the IMU alone: the image matches nothing in the map
  kLost,      // no pose for this frame; the map is kept and every new frame tries to relocalize
};

// Returns "initializing", "tracking", "inertial" or "lost".
const char* ToString(TrackingState state);

// Returns whether the frame has a pose: kTracking and kInertial.
bool HasPose(TrackingState state);

// Reason why a frame has no pose.
enum class LossReason {
  kDark,           // too few features: hardly any light
  kBlurred,        // too few features, and less sharp than usual
  kPlain,          // too few features: no texture
  kNoDepth,        // too few features with depth
  kTooFast,        // at constant velocity the image has shifted by many search windows
  kContradictory,  // most matches with the last frame are inconsistent with the rest
  kAllMoving,      // most features are on dynamic objects
  kUnknownPlace,   // nothing in the map is recognized
  kRepeatedImage,  // the colour image repeats the previous one, for too long
  kDeadReckoning,  // nothing in the map is recognized, for longer than an IMU can bridge
};

// Returns "dark", "blurred", "plain", "no depth", "too fast", "contradictory", "all moving",
// "unknown place", "repeated image" or "dead reckoning".
const char* ToString(LossReason reason);

// An unobservable (degenerate) direction of the camera pose: translation and rotation in C, the
// rotation as the displacement of a point at the depth of the scene, so that the two compare.
struct UnobservableDirection {
  Eigen::Vector3d translation_C = Eigen::Vector3d::Zero();  // of unit length together with
  Eigen::Vector3d rotation_C = Eigen::Vector3d::Zero();     // this rotation
  double sigma = 0.0;  // [m] along it; infinite if there is no constraint at all
};

// Online estimate of the noise of each kind of residual row (docs/noise.md): standard deviations,
// as multiples of the prior noise models.
struct NoiseEstimate {
  static constexpr int kBands = 4;
  using Bands = std::array<double, kBands>;
  static constexpr Bands Ones() { return {1.0, 1.0, 1.0, 1.0}; }

  // Corners, in the image: by pyramid level, of which there are at most 16.
  using Levels = std::array<double, 16>;
  Levels point_px{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  // The same for corners of low contrast (PointFeature::low_contrast), which image noise displaces
  // more.
  Levels low_contrast_px{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  // Corners that keyframes have refined (LocalMapperOptions::refine_corners).
  Levels refined_px{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  // Their depth, by depth: up to 1 m, 2 m, 4 m, beyond.
  Bands point_depth = Ones();
  Bands edge_depth = Ones();  // the same where the readings around the corner differ
  // Segments, across them: by length, up to 1/16, 1/8, 1/4 of the image's width, beyond.
  Bands line_px = Ones();
  Bands line_depth = Ones();  // by depth
};

}  // namespace highwall
