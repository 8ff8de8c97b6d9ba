#include "simulate/scenes/drive.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "simulate/motion/course.h"
#include "simulate/scenes/relief.h"
#include "simulate/scenes/road_surface.h"
#include "simulate/scenes/roadside.h"
#include "simulate/scenes/terrain_kit.h"
#include "simulate/scenes/vehicle.h"

namespace highwall::simulate {
namespace {

constexpr double kLength = 2000.0;            // [m]
constexpr double kSpacing = 0.5;              // [m] along the road
constexpr double kRight = -2.6, kLeft = 3.4;  // [m] of the walls
constexpr double kWall = 3.2;                 // [m] their height

// Returns a closed course of that length with bends and hills of 4 m.
Course DriveCourse(std::uint64_t seed) {
  constexpr int kPoints = 200;
  RandomSequence random(Mix(seed));
  const double a = random.Uniform(0.0, 2.0 * std::numbers::pi);
  const double b = random.Uniform(0.0, 2.0 * std::numbers::pi);
  const auto ring = [&](double size) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < kPoints; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kPoints;
      const double radius =
          size * (1.0 + 0.25 * std::cos(2.0 * angle + a) + 0.08 * std::cos(7.0 * angle + b));
      points.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                          2.0 * (1.0 - std::cos(3.0 * angle)));
    }
    return points;
  };
  const double size = kLength / (2.0 * std::numbers::pi);
  return Course(ring(size * kLength / Course(ring(size)).length()));
}

void AddGround(Terrain* terrain) {
  constexpr int kColumns = 13;
  const ValueNoise grain{.wavelength = 0.5f, .octaves = 6, .seed = terrain->Seed()};
  const int texture =
      terrain->scene.AddTexture(std::make_unique<NoiseTexture>(Rgb(0.5, 0.47, 0.43), 0.8f, grain));
  const Course& course = terrain->course;
  const int rows = static_cast<int>(course.length() / kSpacing) + 1;
  AddSheet(
      rows, kColumns, texture,
      [&](int i, int j) -> ReliefPoint {
        const double s = course.length() * i / (rows - 1);
        const double beside = kRight + (kLeft - kRight) * j / (kColumns - 1);
        return {course.At(s).Point(beside, terrain->surface.Height(s, beside)),
                {.st = Eigen::Vector2d(s, beside).cast<float>()}};
      },
      &terrain->scene);
}

// left: side of the road.
void AddWall(bool left, Terrain* terrain) {
  constexpr int kColumns = 9;
  const int texture = terrain->scene.AddTexture(std::make_unique<MasonryTexture>(
      MasonryOptions{.cell = {0.6f, 0.3f},
                     .joint = 0.03f,
                     .contrast = 0.6f,
                     .noise = {.wavelength = 0.25f, .octaves = 5, .seed = terrain->Seed()}}));
  const ValueNoise relief{.wavelength = 4.0f,
                          .octaves = 3,
                          .seed = terrain->Seed(),
                          .period = static_cast<float>(terrain->course.length())};
  const Course& course = terrain->course;
  const int rows = static_cast<int>(course.length() / kSpacing) + 1;
  AddSheet(
      rows, kColumns, texture,
      [&](int i, int j) -> ReliefPoint {
        const double s = course.length() * i / (rows - 1);
        // Upwards on the right and downwards on the left, so that the lit side is that of the road.
        const double share = static_cast<double>(j) / (kColumns - 1);
        const double up = kWall * (left ? share : 1.0 - share) - 0.3;
        const Eigen::Vector2f st = Eigen::Vector2d(s, up).cast<float>();
        const double wave = 0.5 * static_cast<double>(relief(st, 1e-3f));
        return {course.At(s).Point(left ? kLeft + wave : kRight + wave, up), {.st = st}};
      },
      &terrain->scene);
}

}  // namespace

Simulation SimulateDrive(const SimulationOptions& options) {
  options.Validate();
  Terrain terrain(DriveCourse(options.seed), {}, {.speed = 2.0}, Mix(options.seed + 2));
  terrain.scene.sky = {.horizon = Rgb(0.8, 0.8, 0.8), .zenith = Rgb(0.5, 0.62, 0.8)};
  AddGround(&terrain);
  AddWall(false, &terrain);
  AddWall(true, &terrain);
  AddRoadside(terrain.course, terrain.surface,
              {.right = -1.7,
               .left = 2.6,
               .marker_spacing = 7.0,
               .sign_spacing = 12.0,
               .pole_spacing = 40.0,
               .pipe = false},
              terrain.random.Bits(), &terrain.scene);
  return MakeSimulation(std::move(terrain), options);
}

}  // namespace highwall::simulate
