#pragma once

#include <array>

namespace highwall::apps {

// Viridis (Smith and van der Walt, 2015) for 0 (dark violet) to 1 (yellow), as red, green and blue,
// 0 to 255: read alike with every kind of colour vision, and ever lighter. Values beyond count as
// the nearest end.
std::array<double, 3> Viridis(double share);

}  // namespace highwall::apps
