#pragma once

#include <array>

namespace highwall::apps {

// Returns the viridis colour (Smith and van der Walt, 2015) of a value from 0 (dark violet) to 1
// (yellow) as red, green and blue, 0 to 255. Its lightness increases monotonically, and it is
// readable with every kind of colour vision. Values outside [0, 1] are clamped.
std::array<double, 3> Viridis(double share);

}  // namespace highwall::apps
