#include "simulate/scenes/rock_wall.h"

#include <cmath>

#include "simulate/scenes/relief.h"

namespace highwall::simulate {
namespace {

constexpr float kFinest = 1e-3f;  // [m] footprint of geometric noise

double RockNoise(const ValueNoise& noise, double s, double t) {
  return static_cast<double>(noise(Eigen::Vector2d(s, t).cast<float>(), kFinest));
}

}  // namespace

void AddRockWall(const Course& course, const RoadSurface& surface, const Strata& strata,
                 const RockWallOptions& options, Scene* scene) {
  const double side = options.left ? 1.0 : -1.0;
  const double length = course.length();
  const ValueNoise crest{
      .wavelength = 2.5f, .octaves = 4, .seed = strata.seed() + 31, .period = strata.period()};
  const ValueNoise rough{
      .wavelength = 0.7f, .octaves = 4, .seed = strata.seed() + 32, .period = strata.period()};
  const auto top = [&](double s) {
    return options.top + options.top_swing * RockNoise(crest, s, 0.0);
  };
  // Returns the distance of the wall from the course at height z [m]; dust smooths it.
  const auto distance = [&](const Course::Frame& frame, double s, double z, double dust) {
    const Strata::Place place = strata.At(Eigen::Vector2d(s, z).cast<float>());
    const double relief = static_cast<double>(place.recess) + 0.14 * RockNoise(rough, s, z);
    return options.toe + options.lean * (z - frame.p_W.z()) + relief * (1.0 - 0.75 * dust);
  };
  const auto dust_at = [&](double s) {
    return options.dusty ? surface.Dust(s, side * (options.toe + 0.5)) : 0.0;
  };

  const int rows = static_cast<int>(length / options.spacing) + 1;
  const int face = static_cast<int>((options.top - options.bottom) / options.spacing) + 1;
  AddSheet(
      rows, face, options.rock,
      [&](int i, int j) -> ReliefPoint {
        const double s = length * i / (rows - 1);
        const Course::Frame frame = course.At(s);
        const double bottom = frame.p_W.z() + options.bottom;
        const int upwards = options.left ? j : face - 1 - j;
        const double z = bottom + (top(s) - bottom) * upwards / (face - 1);
        const double dust = dust_at(s);
        Eigen::Vector3d p_W = frame.Point(side * distance(frame, s, z, dust), 0.0);
        p_W.z() = z;
        return {p_W, {.st = Eigen::Vector2d(s, z).cast<float>(), .dust = static_cast<float>(dust)}};
      },
      scene);

  constexpr double kLedgeSpacing = 0.12;  // [m]
  const int coarse_rows = static_cast<int>(length / kLedgeSpacing) + 1;
  const int ledge = static_cast<int>(options.bench / kLedgeSpacing) + 2;
  AddSheet(
      coarse_rows, ledge, options.ground,
      [&](int i, int j) -> ReliefPoint {
        const double s = length * i / (coarse_rows - 1);
        const Course::Frame frame = course.At(s);
        const double z = top(s), dust = dust_at(s);
        const int outwards = options.left ? j : ledge - 1 - j;
        const double out = options.bench * outwards / (ledge - 1);
        Eigen::Vector3d p_W = frame.Point(side * (distance(frame, s, z, dust) + out), 0.0);
        p_W.z() = z + (outwards == 0 ? 0.0 : 0.1 * out + 0.12 * RockNoise(rough, s, out));
        return {p_W, {.st = p_W.head<2>().cast<float>(), .dust = 0.2f}};
      },
      scene);
}

}  // namespace highwall::simulate
