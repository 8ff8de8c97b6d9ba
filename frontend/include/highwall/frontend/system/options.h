#pragma once

#include <highwall/frontend/features/options.h>
#include <highwall/frontend/inertial/options.h>
#include <highwall/frontend/local/options.h>
#include <highwall/frontend/loops/options.h>
#include <highwall/frontend/map/options.h>
#include <highwall/frontend/tracking/options.h>

namespace highwall {

// When the map goes on in a new submap (Map).
struct SubmapOptions {
  bool enabled = true;
  // [s] >= 0: without a pose, before the next frame that can begins a submap; a submap that did not
  // live so long is given up as fast.
  double patience = 0.3;

  void Validate() const;
};

struct SlamOptions {
  FrameBuilderOptions frame{};
  MeasurementOptions measurement{};
  TrackerOptions tracker{};
  KeyFramePolicyOptions keyframes{};
  LocalMapperOptions mapper{};
  InertialOptions inertial{};  // where there is an IMU
  LoopCloserOptions loops{};
  SubmapOptions submaps{};
  // The map that is given stays as it is, but for how often its landmarks were looked for and
  // found: frames find their pose in it, none becomes a keyframe. Images alone, without an IMU.
  bool localize_only = false;

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The options with everything on the caller's thread, in lockstep: the same input then gives the
// same output, bit for bit.
SlamOptions Deterministic(SlamOptions options);

}  // namespace highwall
