#pragma once

#include <vector>

#include "simulate/camera/simulation.h"
#include "simulate/camera/stretch.h"

namespace highwall::simulate {

// Simulates an open pit: a lap of about 50 m over its floor and a ramp, driven at 0.6 m/s, next to
// a highwall of three benches of 2.4 m. A stockpile, boulders and the path across lie inside the
// lap, so that places are revisited from other viewpoints before the lap closes. Along the path:
// bumps, a face covered with dust, the deep shadow of the wall, dust in the air, a washboard. The
// seed determines rock, stones, bumps and places. Throws InvalidArgument.
Simulation SimulateMine(const SimulationOptions& options);

// Returns the stretches of that simulation without building it.
std::vector<Stretch> MineStretches(const SimulationOptions& options);

}  // namespace highwall::simulate
