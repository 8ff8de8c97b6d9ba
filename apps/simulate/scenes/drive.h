#pragma once

#include "simulate/camera/simulation.h"

namespace highwall::simulate {

// Simulates a closed road of 2 km between two masonry walls with irregular course, 6 m apart, with
// posts and signs; driven at 2 m/s. The scene has few large triangles: the length of the path
// matters, not its appearance. The seed determines bends, walls and places. Throws InvalidArgument.
Simulation SimulateDrive(const SimulationOptions& options);

}  // namespace highwall::simulate
