#include "plots/colour_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace highwall::apps {

std::array<double, 3> Viridis(double share) {
  constexpr std::array<std::array<double, 3>, 10> kStops = {{{68.0, 1.0, 84.0},
                                                             {72.0, 40.0, 120.0},
                                                             {62.0, 74.0, 137.0},
                                                             {49.0, 104.0, 142.0},
                                                             {38.0, 130.0, 142.0},
                                                             {31.0, 158.0, 137.0},
                                                             {53.0, 183.0, 121.0},
                                                             {110.0, 206.0, 88.0},
                                                             {181.0, 222.0, 43.0},
                                                             {253.0, 231.0, 37.0}}};
  const double at = std::clamp(share, 0.0, 1.0) * (kStops.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  std::array<double, 3> rgb;
  for (std::size_t c = 0; c < 3; ++c) {
    rgb[c] = std::lerp(kStops[i][c], kStops[i + 1][c], at - static_cast<double>(i));
  }
  return rgb;
}

}  // namespace highwall::apps
