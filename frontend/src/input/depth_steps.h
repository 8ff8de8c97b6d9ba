#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace highwall {

// Histogram of the stored depth values, indexed by value.
using DepthHistogram = std::span<const std::uint64_t>;

// A regular spacing and its coherence: the length of the mean of exp(2 pi i value / spacing), 1 if
// all values are multiples of the spacing.
struct DepthSteps {
  double spacing = 0.0;
  double coherence = 0.0;
};

// Finds the spacing of 1 / value: the disparity steps of a triangulating sensor. Empty if there is
// none that the rounding of the stored values would not hide.
std::optional<DepthSteps> FindInverseSteps(DepthHistogram histogram);

// Finds the spacing of the values themselves: 1, or more if they were multiplied by a factor after
// rounding. Empty if they are too few and too sparse to decide.
std::optional<DepthSteps> FindUnit(DepthHistogram histogram);

}  // namespace highwall
