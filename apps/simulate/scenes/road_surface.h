#pragma once

#include <cstdint>
#include <vector>

#include "simulate/camera/stretch.h"
#include "simulate/materials/texture.h"

namespace highwall::simulate {

// The ground of a haul road 4.4 m wide, by its own coordinates: s [m] along the line that a vehicle
// drives, `left` [m] of it.
class RoadSurface {
 public:
  static constexpr double kMiddle = 0.75;  // [m] vehicles keep right: the middle lies on their left

  // stretches: of one lap, in seconds at `speed` [m/s]; length [m] of the lap.
  RoadSurface(std::vector<Stretch> stretches, double speed, double length, std::uint32_t seed);

  // Above that line, [m]: undulation, ruts, shoulders, and the bumps and the washboard of the
  // bumpy and the blurred stretches.
  double Height(double s, double left) const;
  // How much dust lies there, [0, 1]; nearly 1 in the low-texture stretches, from where a camera
  // that enters one sees the ground to where one that leaves it does.
  double Dust(double s, double left) const;
  // How dark wheels have worn it: 1 = not at all.
  double Tint(double s, double left) const;

 private:
  double At(StretchKind kind, double s) const;

  std::vector<Stretch> stretches_;
  double speed_, length_;
  ValueNoise undulation_, bumps_, shoulder_, patches_;
};

}  // namespace highwall::simulate
