#pragma once

#include <vector>

#include "simulate/camera/simulation.h"
#include "simulate/camera/stretch.h"

namespace highwall::simulate {

// Simulates the field test of the paper: a gravel haul road 4.4 m wide between walls of bedded
// rock, 10 m straight, then a bend of 10 m, and the same again to a closed lap of about 40 m;
// driven at 0.6 m/s. It is lined with boulders, marker posts, signs, a pipe and a cable. It is
// bumpy from 5 m on, a washboard from 10 m, and covered with dust from 14 m. The seed determines
// rock, stones, bumps and places. Throws InvalidArgument.
Simulation SimulateRoad(const SimulationOptions& options);

// Returns the stretches of that simulation without building it.
std::vector<Stretch> RoadStretches(const SimulationOptions& options);

}  // namespace highwall::simulate
