#pragma once

#include <vector>

#include <highwall/core/pose.h>

#include "simulate/camera/simulation.h"
#include "simulate/materials/scene.h"
#include "simulate/motion/camera_path.h"

namespace highwall::simulate {

// Maximum lap time of the camera with room for a person between it and the furniture [s].
inline constexpr double kLongestLapWithVisitor = 12.0;

// Returns the pose of a person who walks round the room on an ellipse outside of the camera's path,
// alternately behind and ahead of the camera: in view half of the time. t [s] since the first
// frame. T_WB: x forward, y left, z up, on the floor.
Pose VisitorAt(const CameraPath& path, double t);

// Returns the person as a dynamic object in the light of the room.
MovingScene MakeVisitor(const CameraPath& path, const std::vector<Light>& lights, double ambient);

}  // namespace highwall::simulate
