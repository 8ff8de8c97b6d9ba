#pragma once

#include <vector>

#include "simulate/camera/simulation.h"
#include "simulate/camera/stretch.h"

namespace highwall::simulate {

// An open pit: a lap of about 50 m over its floor and a ramp, driven at 0.6 m/s, beside a highwall
// of three benches of 2.4 m; inside the lap lie a stockpile, boulders and the way across, so that
// places are seen again from elsewhere before the lap closes. On the way: bumps, a face covered
// with dust, the deep shadow of the wall, dust in the air, a washboard. The seed draws rock,
// stones, bumps and places. Throws InvalidArgument.
Simulation SimulateMine(const SimulationOptions& options);

// The stretches of that simulation, without the work of building it.
std::vector<Stretch> MineStretches(const SimulationOptions& options);

}  // namespace highwall::simulate
