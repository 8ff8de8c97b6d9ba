#pragma once

#include <cstddef>

namespace highwall {

// What holds a pose, counted: a line is worth two points, since both of its ends are measured.
constexpr int Support(int points, int lines) {
  return points + 2 * lines;
}
constexpr std::size_t Support(std::size_t points, std::size_t lines) {
  return points + 2 * lines;
}

}  // namespace highwall
