#pragma once

#include <highwall/core/trajectory.h>

namespace highwall::python {

// A type of its own: as a std::vector it would become a list of pairs.
struct PythonTrajectory {
  Trajectory poses;
};

}  // namespace highwall::python
