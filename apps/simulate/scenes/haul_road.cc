#include "simulate/scenes/haul_road.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "simulate/motion/course.h"
#include "simulate/scenes/road_surface.h"
#include "simulate/scenes/roadside.h"
#include "simulate/scenes/rock_wall.h"
#include "simulate/scenes/terrain_kit.h"
#include "simulate/scenes/vehicle.h"

namespace highwall::simulate {
namespace {

constexpr double kStraight = 8.0, kBend = 4.7;  // [m] length, radius

Course RoadCourse() {
  // Evenly spaced points of a stadium; the spline smooths the transition from straight to bend.
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

// Stretches of a lap; the second half repeats the first.
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
  const Course course = RoadCourse();
  Terrain terrain(course, MakeStretches(vehicle.speed, course.length()), vehicle,
                  Mix(options.seed));
  const RoadSurface& surface = terrain.surface;
  Scene* const scene = &terrain.scene;
  scene->sky = {.horizon = Rgb(0.78, 0.8, 0.82), .zenith = Rgb(0.5, 0.62, 0.8)};
  const TerrainTextures textures = AddTerrainTextures({12.0, 9.0}, -1.0, 3.0, &terrain);
  AddRoad(-2.15, 3.65, textures.gravel, &terrain);
  AddRockWall(course, surface, terrain.strata,
              {.toe = 1.55, .top = 2.2, .rock = textures.rock, .ground = textures.gravel}, scene);
  AddRockWall(course, surface, terrain.strata,
              {.left = true,
               .toe = 3.15,
               .lean = 0.15,
               .top = 1.8,
               .bench = 0.5,
               .rock = textures.rock,
               .ground = textures.gravel},
              scene);
  AddRoadside(course, surface, {}, terrain.random.Bits(), scene);
  AddDebris(course, surface, {}, textures.stone, terrain.random.Bits(), scene);
  return MakeSimulation(std::move(terrain), options);
}

std::vector<Stretch> RoadStretches(const SimulationOptions& options) {
  const double speed = VehicleOptions().speed, length = RoadCourse().length();
  return LayOut(MakeStretches(speed, length), length / speed, options);
}

}  // namespace highwall::simulate
