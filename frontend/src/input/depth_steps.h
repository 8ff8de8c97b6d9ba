#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace highwall {

// How often each stored depth was seen, by its value.
using DepthHistogram = std::span<const std::uint64_t>;

// A regular spacing and how sharply the values keep to it: the length of the mean of
// exp(2 pi i value / spacing), 1 where all of them do.
struct DepthSteps {
  double spacing = 0.0;
  double coherence = 0.0;
};

// The spacing of 1 / value: the disparities that a triangulating sensor tells apart. Empty where
// there is none that the rounding of the stored values would not hide.
std::optional<DepthSteps> FindInverseSteps(DepthHistogram histogram);

// The spacing of the values themselves: 1, or more where they were multiplied by a factor after
// they had been rounded. Empty where they are too few and far between to tell.
std::optional<DepthSteps> FindUnit(DepthHistogram histogram);

}  // namespace highwall
