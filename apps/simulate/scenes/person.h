#pragma once

#include <highwall/core/pose.h>

#include "simulate/materials/scene.h"

namespace highwall::simulate {

// Pairs of steps per second of a person who walks at the speed of the camera.
inline constexpr double kStepsPerSecond = 0.7;

// Adds a person in a vest, made of boxes, 1.7 m tall. B: x forward, y left, z up, on the ground.
// stride [rad]: phase of the legs.
void AddPerson(const Pose& T_WB, double stride, Scene* scene);

}  // namespace highwall::simulate
