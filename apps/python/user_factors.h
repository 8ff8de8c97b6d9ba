#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <string>
#include <vector>

#include "bindings.h"
#include "python_slam.h"

namespace highwall::python {

// Calls SlamSystem::AddFactor(). frame: of AddReferenceFrame(). source: name of the sensor. An
// exception raised by a Python factor while SLAM runs goes to sys.unraisablehook, because it may
// occur on any thread, and the adjustment with that factor fails.
void AddFactor(Slam& self, std::vector<Stamp> stamps, const py::object& factor,
               std::optional<int> frame, const py::object& loss, std::string source);

}  // namespace highwall::python
