#include "simulate/haul_road.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "simulate/baked_texture.h"
#include "simulate/course.h"
#include "simulate/gravel.h"
#include "simulate/relief.h"
#include "simulate/road_surface.h"
#include "simulate/roadside.h"
#include "simulate/rock_wall.h"
#include "simulate/strata.h"
#include "simulate/sunlight.h"
#include "simulate/vehicle.h"

namespace highwall::simulate {
namespace {

constexpr double kStraight = 8.0, kBend = 4.0;  // [m] length, radius
constexpr double kGroundSpacing = 0.05;         // [m]

Course MakeCourse() {
  // Points of a stadium, evenly spaced; the spline rounds the change from straight to bend.
  constexpr double kStep = 1.0;  // [m]
  constexpr double kHalfLap = kStraight + std::numbers::pi * kBend;
  const int count = static_cast<int>(std::lround(2.0 * kHalfLap / kStep));
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double along = 2.0 * kHalfLap * i / count;
    const bool back = along >= kHalfLap;
    const double s = back ? along - kHalfLap : along;
    Eigen::Vector3d p(s - 0.5 * kStraight, -kBend, 0.0);
    if (s > kStraight) {
      const double angle = (s - kStraight) / kBend;
      p = {0.5 * kStraight + kBend * std::sin(angle), -kBend * std::cos(angle), 0.0};
    }
    points.push_back(back ? Eigen::Vector3d(-p.x(), -p.y(), 0.0) : p);
  }
  return Course(std::move(points));
}

// Of a lap; the second half repeats the first.
std::vector<Stretch> MakeStretches(double speed, double length) {
  std::vector<Stretch> stretches;
  for (const double half : {0.0, 0.5 * length}) {
    stretches.push_back({StretchKind::kBumpy, (half + 4.0) / speed, (half + 8.0) / speed});
    stretches.push_back({StretchKind::kBlurred, (half + 10.0) / speed, (half + 13.0) / speed});
    stretches.push_back({StretchKind::kLowTexture, (half + 15.0) / speed, (half + 18.0) / speed});
  }
  return stretches;
}

}  // namespace

Simulation SimulateRoad(const SimulationOptions& options) {
  options.Validate();
  const VehicleOptions vehicle;
  const Course course = MakeCourse();
  std::vector<Stretch> stretches = MakeStretches(vehicle.speed, course.length());
  RandomSequence random(Mix(options.seed));
  const auto seed = [&random] { return static_cast<std::uint32_t>(random.Bits()); };
  const RoadSurface surface(stretches, vehicle.speed, course.length(), seed());

  Scene scene;
  scene.sky = {.horizon = Rgb(0.78, 0.8, 0.82), .zenith = Rgb(0.5, 0.62, 0.8)};
  constexpr float kHalfX = 12.0f, kHalfY = 8.0f, kTexel = 0.004f;
  const int ground = scene.AddTexture(std::make_unique<BakedTexture>(
      std::make_unique<GravelTexture>(GravelOptions{.seed = seed()}),
      Eigen::Vector2f(-kHalfX, -kHalfY), Eigen::Vector2f(2 * kHalfX, 2 * kHalfY), kTexel));
  const Strata strata(static_cast<float>(course.length()), seed());
  const int rock = scene.AddTexture(std::make_unique<BakedTexture>(
      std::make_unique<StrataTexture>(strata, StrataColours{}), Eigen::Vector2f(0.0f, -1.0f),
      Eigen::Vector2f(strata.period(), 4.0f), kTexel));
  const int stone = scene.AddTexture(std::make_unique<BakedTexture>(
      std::make_unique<NoiseTexture>(Rgb(0.52, 0.47, 0.41), 0.7f,
                                     ValueNoise{.wavelength = 0.15f, .octaves = 6, .seed = seed()}),
      Eigen::Vector2f(0.0f, 0.0f), Eigen::Vector2f(4.0f, 4.0f), 0.5f * kTexel));

  constexpr double kHalfWidth = 2.9;  // [m] the ground reaches below the walls
  const int rows = static_cast<int>(course.length() / kGroundSpacing) + 1;
  const int columns = static_cast<int>(2.0 * kHalfWidth / kGroundSpacing) + 1;
  AddSheet(
      rows, columns, ground,
      [&](int i, int j) -> ReliefPoint {
        const double s = course.length() * i / (rows - 1);
        const double left = kHalfWidth * (2.0 * j / (columns - 1) - 1.0);
        const Eigen::Vector3d p_W = course.At(s).Point(left, surface.Height(s, left));
        return {p_W,
                {.st = p_W.head<2>().cast<float>(),
                 .dust = static_cast<float>(surface.Dust(s, left)),
                 .light = static_cast<float>(surface.Tint(s, left))}};
      },
      &scene);
  AddRockWall(course, surface, strata, {.toe = 2.3, .top = 2.2, .rock = rock, .ground = ground},
              &scene);
  AddRockWall(course, surface, strata,
              {.left = true,
               .toe = 2.4,
               .lean = 0.15,
               .top = 1.8,
               .bench = 0.5,
               .rock = rock,
               .ground = ground},
              &scene);
  AddRoadside(course, surface, {}, random.Bits(), &scene);
  AddDebris(course, surface, {}, stone, random.Bits(), &scene);
  BakeSunlight({}, &scene);

  SplineTrajectory drive = Drive(course, surface, vehicle, random.Bits());
  return Simulation(std::move(scene), std::move(drive), options);
}

}  // namespace highwall::simulate
