#pragma once

#include <vector>

#include <highwall/core/pose.h>

#include "simulate/camera/simulation.h"
#include "simulate/materials/scene.h"
#include "simulate/motion/camera_path.h"

namespace highwall::simulate {

// Laps of the camera that leave somebody room to walk between it and the furniture [s].
inline constexpr double kLongestLapWithVisitor = 12.0;

// Where somebody walks who goes round the room on an ellipse outside of the camera's path, along
// with the camera, behind it and ahead of it by turns: in view half of the time. t [s] since the
// first frame. T_WB: x forward, y left, z up, on the floor.
Pose VisitorAt(const CameraPath& path, double t);

// The same in the light of the room.
MovingScene MakeVisitor(const CameraPath& path, const std::vector<Light>& lights, double ambient);

}  // namespace highwall::simulate
