#pragma once



namespace highwall {

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

}  // namespace highwall
