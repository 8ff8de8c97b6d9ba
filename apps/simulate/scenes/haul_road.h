#pragma once

#include <vector>

#include "simulate/camera/simulation.h"
#include "simulate/camera/stretch.h"

namespace highwall::simulate {

// The field test of the paper: a haul road of gravel 4.4 m wide between walls of bedded rock, 10 m
// straight, then 10 m in a bend, and the same again to a closed lap of about 40 m; driven at
// 0.6 m/s. Boulders, marker posts, signs, a pipe and a cable line it. From 5 m on it is bumpy, from
// 10 m a washboard, from 14 m covered with dust. The seed draws rock, stones, bumps and places.
// Throws InvalidArgument.
Simulation SimulateRoad(const SimulationOptions& options);

// The stretches of that simulation, without the work of building it.
std::vector<Stretch> RoadStretches(const SimulationOptions& options);

}  // namespace highwall::simulate
