#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <vector>

#include <highwall/frontend/system/slam_system.h>

#include "bindings.h"
#include "exclusive.h"

namespace highwall::python {

// SlamSystem::AddFactor(). frame: of AddReferenceFrame(). What a factor written in Python raises
// while SLAM runs goes to sys.unraisablehook, for it may be on any thread, and the adjustment that
// it took part in fails.
void AddFactor(Exclusive<SlamSystem>& self, std::vector<Stamp> stamps, const py::object& factor,
               std::optional<int> frame, const py::object& loss);

}  // namespace highwall::python
