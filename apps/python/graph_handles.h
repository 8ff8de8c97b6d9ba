#pragma once

#include <pybind11/pybind11.h>

#include <vector>

#include <highwall/core/factor_graph.h>

#include "value.h"

namespace highwall::python {

// Handle of a variable with the type of its block.
struct PythonVariable {
  VariableId id;
  ValueType type;
};

// Convert arguments (factor, variable, ...) of add_factor().
std::vector<VariableId> Ids(const std::vector<PythonVariable>& variables);
std::vector<PythonVariable> ReadVariables(const py::args& variables);

}  // namespace highwall::python
