#pragma once

#include <highwall/core/pose.h>

#include "simulate/materials/scene.h"

namespace highwall::simulate {

// How many pairs of steps somebody takes who walks at the speed of the camera.
inline constexpr double kStepsPerSecond = 0.7;

// Somebody on foot in a vest, made of boxes, 1.7 m tall. B: x forward, y left, z up, on the ground.
// stride [rad]: where the legs are in their swing.
void AddPerson(const Pose& T_WB, double stride, Scene* scene);

}  // namespace highwall::simulate
