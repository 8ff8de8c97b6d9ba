#pragma once

#include <cstdint>

#include "simulate/motion/course.h"
#include "simulate/motion/spline_trajectory.h"
#include "simulate/scenes/road_surface.h"

namespace highwall::simulate {

// Small four-wheeled rover with the camera.
struct VehicleOptions {
  double speed = 0.6;          // [m/s] > 0
  double wheelbase = 0.5;      // [m] > 0
  double track = 0.5;          // [m] > 0
  double wander = 0.12;        // [m] lateral deviation from the course
  double camera_ahead = 0.25;  // [m] of the vehicle's middle
  double camera_height = 0.8;  // [m]
  double camera_pitch = -0.2;  // [rad] below the horizon
};

// Returns one lap: the wheels follow the ground, the body rests on the wheels, the camera is fixed
// to it.
SplineTrajectory Drive(const Course& course, const RoadSurface& surface,
                       const VehicleOptions& options, std::uint64_t seed);

}  // namespace highwall::simulate
