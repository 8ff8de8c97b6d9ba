#pragma once

#include <array>

#include <Eigen/Core>

// What becomes of the pose of a frame.
namespace [[gnu::visibility("default")]] highwall {

// What is known of the pose of a frame.
enum class TrackingState {
  kInitializing,  // no map yet: the first frames had too little depth or texture
  kTracking,
  kInertial,  // the pose is that of the IMU alone: the image shows nothing that is known
  kLost,      // no pose for this frame; the map is kept and every new frame tries to relocalize
};

// "initializing", "tracking", "inertial" or "lost".
const char* ToString(TrackingState state);

// The frame has a pose: kTracking and kInertial.
bool HasPose(TrackingState state);

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

// A small motion of the camera that its image hardly tells: translation and rotation in C, the
// rotation as the way it moves a point at the depth of the scene, so that the two compare.
struct OpenDirection {
  Eigen::Vector3d translation_C = Eigen::Vector3d::Zero();  // together with the rotation of
  Eigen::Vector3d rotation_C = Eigen::Vector3d::Zero();     // length 1
  double sigma = 0.0;  // [m] along it; infinite where nothing at all is known
};

// How noisy each kind of residual row has turned out to be (docs/noise.md): standard deviations, as
// multiples of what is known beforehand.
struct NoiseEstimate {
  static constexpr int kBands = 4;
  using Bands = std::array<double, kBands>;
  static constexpr Bands Ones() { return {1.0, 1.0, 1.0, 1.0}; }

  // Corners, across the image: by pyramid level, of which there are 16 at most.
  using Levels = std::array<double, 16>;
  Levels point_px{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  // Corners that keyframes have refined (LocalMapperOptions::refine_corners).
  Levels refined_px{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  // Their depth, by depth: to 1 m, to 2 m, to 4 m, beyond.
  Bands point_depth = Ones();
  Bands edge_depth = Ones();  // the same where readings about the corner differ
  // Segments, across them: by length, to 1/16, 1/8, 1/4 of the image's width, beyond.
  Bands line_px = Ones();
  Bands line_depth = Ones();  // by depth
};

}  // namespace highwall
