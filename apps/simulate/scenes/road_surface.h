#pragma once

#include <cstdint>
#include <vector>

#include "simulate/camera/stretch.h"
#include "simulate/materials/texture.h"

namespace highwall::simulate {

// Ground of a haul road 4.4 m wide, in its own coordinates: s [m] along the driven line, `left` [m]
// of it.
class RoadSurface {
 public:
  static constexpr double kMiddle = 0.75;  // [m] vehicles keep right: the middle is on their left

  // stretches: of one lap, in seconds at `speed` [m/s]; length [m] of the lap.
  RoadSurface(std::vector<Stretch> stretches, double speed, double length, std::uint32_t seed);

  // Returns the height above that line [m]: undulation, ruts, shoulders, and the bumps and
  // washboard of the bumpy and blurred stretches.
  double Height(double s, double left) const;
  // Returns the amount of dust, [0, 1]; nearly 1 in the low-texture stretches, from the ground seen
  // by a camera that enters one to that seen by a camera that leaves it.
  double Dust(double s, double left) const;
  // Returns the darkening by wheels: 1 = none.
  double Tint(double s, double left) const;

 private:
  double At(StretchKind kind, double s) const;

  std::vector<Stretch> stretches_;
  double speed_, length_;
  ValueNoise undulation_, bumps_, shoulder_, patches_;
};

}  // namespace highwall::simulate
