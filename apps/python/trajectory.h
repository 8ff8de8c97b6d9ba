#pragma once

#include <highwall/core/trajectory.h>

namespace highwall::python {

// Separate type: a std::vector would be converted to a list of pairs.
struct PythonTrajectory {
  Trajectory poses;
};

}  // namespace highwall::python
