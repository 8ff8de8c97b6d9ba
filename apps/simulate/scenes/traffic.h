#pragma once

#include "simulate/camera/simulation.h"
#include "simulate/motion/course.h"
#include "simulate/scenes/road_surface.h"

namespace highwall::simulate {

// Returns the dynamic objects on the road: a pedestrian worker some metres ahead of the camera, and
// an oncoming dump truck that is met twice a minute. They are made of boxes and cast no shadow on
// the ground.
MovingScene MakeTraffic(const Course& course, const RoadSurface& surface);

}  // namespace highwall::simulate
