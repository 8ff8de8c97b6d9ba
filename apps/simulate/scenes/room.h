#pragma once

#include <cstdint>

#include "simulate/camera/simulation.h"
#include "simulate/materials/scene.h"
#include "simulate/motion/spline_trajectory.h"

namespace highwall::simulate {

// Returns a furnished room, |x| <= 3 m, |y| <= 2.5 m, 0 <= z <= 3 m: brick, plaster, wallpaper,
// tiles, shelves, a desk, tables, boxes and pictures, all along the walls; the middle is free. The
// seed determines colours, prints and the exact places.
Scene MakeRoom(std::uint64_t seed);

// Returns a walk around the middle of the room at head or chest height with the camera looking
// outwards, at 0.45 m/s and less than 60 deg/s, with hand shake. It closes after `duration` [s], in
// as many laps of at most longest_lap (10 to 20 s) as that takes; below 10 s it is the beginning of
// a 10 s lap.
SplineTrajectory MakeRoomTrajectory(double duration, std::uint64_t seed, double longest_lap = 20.0);

// Simulates room and walk; a start at rest precedes the walk. With traffic a person walks there as
// well, and laps take at most kLongestLapWithVisitor. Throws InvalidArgument.
Simulation SimulateRoom(const SimulationOptions& options);

}  // namespace highwall::simulate
