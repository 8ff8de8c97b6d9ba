#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <vector>

#include "bindings.h"
#include "python_slam.h"

namespace highwall::python {

// SlamSystem::AddFactor(). frame: of AddReferenceFrame(). What a factor written in Python raises
// while SLAM runs goes to sys.unraisablehook, for it may be on any thread, and the adjustment that
// it took part in fails.
void AddFactor(Slam& self, std::vector<Stamp> stamps, const py::object& factor,
               std::optional<int> frame, const py::object& loss);

}  // namespace highwall::python
