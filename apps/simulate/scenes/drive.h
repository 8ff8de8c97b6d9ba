#pragma once

#include "simulate/camera/simulation.h"

namespace highwall::simulate {

// A road 2 km long that comes back to where it began, between two walls of masonry that stand 6 m
// apart and waver, with posts and signs; driven at 2 m/s. Made of few large triangles: what counts
// is the length of the way, not its looks. The seed draws bends, walls and places. Throws
// InvalidArgument.
Simulation SimulateDrive(const SimulationOptions& options);

}  // namespace highwall::simulate
