#pragma once

#include "simulate/camera/simulation.h"
#include "simulate/motion/course.h"
#include "simulate/scenes/road_surface.h"

namespace highwall::simulate {

// What moves on the road: a worker on foot some metres ahead of the camera, and a dump truck that
// comes the other way round and is met twice a minute. They are made of boxes and throw no shadow
// on the ground.
MovingScene MakeTraffic(const Course& course, const RoadSurface& surface);

}  // namespace highwall::simulate
