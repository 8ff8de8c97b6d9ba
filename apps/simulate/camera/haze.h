#pragma once

#include <cstdint>

#include "simulate/camera/renderer.h"

namespace highwall::simulate {

// Dust in the air: contrast falls exponentially with depth, in drifting swathes.
struct Haze {
  double density = 0.0;  // [1/m] >= 0, mean extinction
  Colour colour = Rgb(0.66, 0.6, 0.52);
  std::uint32_t seed = 0;
};

// t [s]: the swathes drift with it.
void AddHaze(const Haze& haze, double t, Rendering* rendering);

}  // namespace highwall::simulate
