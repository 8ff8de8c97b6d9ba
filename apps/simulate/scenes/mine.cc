#include "simulate/scenes/mine.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "simulate/motion/course.h"
#include "simulate/scenes/relief.h"
#include "simulate/scenes/road_surface.h"
#include "simulate/scenes/roadside.h"
#include "simulate/scenes/rock_wall.h"
#include "simulate/scenes/terrain_kit.h"
#include "simulate/scenes/vehicle.h"

namespace highwall::simulate {
namespace {

constexpr double kToe = 1.55;     // [m] of the highwall, right of the lap
constexpr double kInside = 2.95;  // [m] left of the lap, where the pit floor begins
constexpr double kBench = 2.4;    // [m] height of a face
constexpr double kLedge = 1.6;    // [m] width of the ledge above it

// Returns a kidney-shaped course that climbs 1.1 m over a ramp and descends again.
Course MineCourse() {
  constexpr int kPoints = 40;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPoints;
    const double radius = 7.6 + 1.3 * std::cos(2.0 * angle) + 0.7 * std::cos(3.0 * angle + 0.6);
    const double height = 0.55 * (1.0 - std::cos(angle + 0.4));
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
  }
  return Course(std::move(points));
}

// Stretches of a lap.
std::vector<Stretch> MakeStretches(double speed) {
  return {{StretchKind::kBumpy, 5.0 / speed, 10.0 / speed},
          {StretchKind::kLowTexture, 13.0 / speed, 16.5 / speed},
          {StretchKind::kLowLight, 21.0 / speed, 26.0 / speed},
          {StretchKind::kDust, 29.0 / speed, 34.0 / speed},
          {StretchKind::kBlurred, 38.0 / speed, 42.0 / speed}};
}

// Adds the floor inside the lap, with a stockpile in its middle.
void AddFloor(const Course& course, const RoadSurface& surface, int texture, std::uint32_t seed,
              Scene* scene) {
  constexpr double kFloorSpacing = 0.1;  // [m]
  const ValueNoise rough{.wavelength = 1.7f, .octaves = 5, .seed = seed};
  const Eigen::Vector3d middle(0.3, 0.0, 0.0);
  const int rows = static_cast<int>(course.length() / kFloorSpacing) + 1;
  constexpr int kColumns = 56;
  AddSheet(
      rows, kColumns, texture,
      [&](int i, int j) -> ReliefPoint {
        const double s = course.length() * i / (rows - 1);
        const Course::Frame frame = course.At(s);
        const double share = static_cast<double>(j) / (kColumns - 1);
        const Eigen::Vector3d edge = frame.Point(kInside, surface.Height(s, kInside));
        Eigen::Vector3d p_W = edge + share * (middle - edge);
        const double wave = static_cast<double>(rough(p_W.head<2>().cast<float>(), 1e-3f));
        const double pile = (p_W - middle).head<2>().norm() / 2.1;
        const double inner = std::min(1.0, 4.0 * share);
        p_W.z() = (1.0 - share) * edge.z() + share * 0.4 + inner * 0.22 * wave +
                  1.5 * std::max(0.0, 1.0 - pile) * (1.0 + 0.5 * wave);
        return {p_W,
                {.st = p_W.head<2>().cast<float>(),
                 .dust = static_cast<float>(surface.Dust(s, kInside) * (1.0 - inner))}};
      },
      scene);
}

void AddHighwall(const Course& course, const RoadSurface& surface, const Strata& strata,
                 const TerrainTextures& textures, Scene* scene) {
  RockWallOptions face{.toe = kToe,
                       .lean = 0.22,
                       .top = 2.9,
                       .bench = kLedge,
                       .rock = textures.rock,
                       .ground = textures.gravel};
  for (int bench = 0; bench < 3; ++bench) {
    AddRockWall(course, surface, strata, face, scene);
    face.toe += kLedge;
    face.bottom = face.top - 1.6;  // well below the ledge at every height of the course
    face.top += kBench;
    face.spacing = 0.1;
    face.dusty = false;
  }
}

}  // namespace

Simulation SimulateMine(const SimulationOptions& options) {
  options.Validate();
  const VehicleOptions vehicle;
  Terrain terrain(MineCourse(), MakeStretches(vehicle.speed), vehicle, Mix(options.seed + 1));
  const Course& course = terrain.course;
  const RoadSurface& surface = terrain.surface;
  Scene* const scene = &terrain.scene;
  scene->sky = {.horizon = Rgb(0.8, 0.8, 0.78), .zenith = Rgb(0.45, 0.6, 0.82)};
  const TerrainTextures textures = AddTerrainTextures({20.0, 20.0}, -1.5, 9.0, &terrain);
  AddRoad(-kToe - 0.6, kInside, textures.gravel, &terrain);
  AddFloor(course, surface, textures.gravel, terrain.Seed(), scene);
  AddHighwall(course, surface, terrain.strata, textures, scene);
  AddRoadside(course, surface, {.marker_spacing = 4.0, .sign_spacing = 11.0, .pipe = false},
              terrain.random.Bits(), scene);
  AddDebris(course, surface, {.pebbles = 18.0}, textures.stone, terrain.random.Bits(), scene);
  AddDebris(course, surface,
            {.pebbles = 0.0, .boulders = 2.5, .right = -1.15, .left = 2.95, .reach = 4.0},
            textures.stone, terrain.random.Bits(), scene);
  return MakeSimulation(std::move(terrain), options);
}

std::vector<Stretch> MineStretches(const SimulationOptions& options) {
  const double speed = VehicleOptions().speed;
  return LayOut(MakeStretches(speed), MineCourse().length() / speed, options);
}

}  // namespace highwall::simulate
