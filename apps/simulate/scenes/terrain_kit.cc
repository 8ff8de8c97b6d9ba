#include "simulate/scenes/terrain_kit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

#include "simulate/materials/baked_texture.h"
#include "simulate/materials/gravel.h"
#include "simulate/scenes/relief.h"
#include "simulate/scenes/sunlight.h"
#include "simulate/scenes/traffic.h"

namespace highwall::simulate {
namespace {

constexpr float kTexel = 0.004f;         // [m] about a pixel at 2.5 m
constexpr double kGroundSpacing = 0.05;  // [m]

// Returns the IMU vibration: low everywhere, full in the bumpy and the blurred stretches.
// stretches: of one lap, period [s] of the lap.
VibrationIntensity VibrationOn(std::vector<Stretch> stretches, double period) {
  return [stretches = std::move(stretches), period](double s) {
    constexpr double kSmoothRoad = 0.15;
    const double t = s - std::floor(s / period) * period;
    return std::max({kSmoothRoad, Intensity(stretches, StretchKind::kBumpy, t),
                     Intensity(stretches, StretchKind::kBlurred, t)});
  };
}

}  // namespace

Terrain::Terrain(Course line, std::vector<Stretch> hard_parts, const VehicleOptions& rover,
                 std::uint64_t seed)
    : vehicle(rover),
      course(std::move(line)),
      stretches(std::move(hard_parts)),
      random(seed),
      surface(stretches, vehicle.speed, course.length(), Seed()),
      strata(static_cast<float>(course.length()), Seed()) {}

Simulation MakeSimulation(Terrain terrain, const SimulationOptions& options) {
  BakeSunlight({}, &terrain.scene);
  SplineTrajectory drive =
      Drive(terrain.course, terrain.surface, terrain.vehicle, terrain.random.Bits());
  VibrationIntensity vibration = VibrationOn(terrain.stretches, drive.period());
  return Simulation(std::move(terrain.scene), std::move(drive), options, std::move(vibration),
                    terrain.stretches, MakeTraffic(terrain.course, terrain.surface));
}

TerrainTextures AddTerrainTextures(const Eigen::Vector2d& half_extent, double lowest,
                                   double highest, Terrain* terrain) {
  const Strata& strata = terrain->strata;
  const auto add = [terrain](std::unique_ptr<const Texture> source, const Eigen::Vector2d& min,
                             const Eigen::Vector2d& size, float texel) {
    return terrain->scene.AddTexture(std::make_unique<BakedTexture>(
        std::move(source), min.cast<float>(), size.cast<float>(), texel));
  };
  TerrainTextures textures;
  textures.gravel = add(std::make_unique<GravelTexture>(GravelOptions{.seed = terrain->Seed()}),
                        -half_extent, 2.0 * half_extent, kTexel);
  textures.rock = add(std::make_unique<StrataTexture>(strata, StrataColours{}), {0.0, lowest},
                      {static_cast<double>(strata.period()), highest - lowest}, kTexel);
  const ValueNoise grain{.wavelength = 0.15f, .octaves = 6, .seed = terrain->Seed()};
  textures.stone = add(std::make_unique<NoiseTexture>(Rgb(0.52, 0.47, 0.41), 0.7f, grain),
                       {0.0, 0.0}, {4.0, 4.0}, 0.5f * kTexel);
  return textures;
}

void AddRoad(double right, double left, int texture, Terrain* terrain) {
  const Course& course = terrain->course;
  const RoadSurface& surface = terrain->surface;
  const int rows = static_cast<int>(course.length() / kGroundSpacing) + 1;
  const int columns = static_cast<int>((left - right) / kGroundSpacing) + 1;
  AddSheet(
      rows, columns, texture,
      [&](int i, int j) -> ReliefPoint {
        const double s = course.length() * i / (rows - 1);
        const double beside = right + (left - right) * j / (columns - 1);
        const Eigen::Vector3d p_W = course.At(s).Point(beside, surface.Height(s, beside));
        return {p_W,
                {.st = p_W.head<2>().cast<float>(),
                 .dust = static_cast<float>(surface.Dust(s, beside)),
                 .light = static_cast<float>(surface.Tint(s, beside))}};
      },
      &terrain->scene);
}

}  // namespace highwall::simulate
