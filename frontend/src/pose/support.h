#pragma once

#include <cstddef>

namespace highwall {

// Returns the support of a pose: a line counts as two points, because both of its ends are
// measured.
constexpr int Support(int points, int lines) {
  return points + 2 * lines;
}
constexpr std::size_t Support(std::size_t points, std::size_t lines) {
  return points + 2 * lines;
}

}  // namespace highwall
