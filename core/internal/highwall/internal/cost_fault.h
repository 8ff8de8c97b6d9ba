#pragma once

#include <span>
#include <string>

#include <ceres/cost_function.h>

namespace [[gnu::visibility("default")]] highwall {
namespace internal {

// Returns the reason why a factor cannot be evaluated at `parameters`: it throws, returns false, or
// is not finite; empty if it can.
std::string FaultOf(const ceres::CostFunction& factor, std::span<const double* const> parameters);

}  // namespace internal
}  // namespace highwall
