#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "simulate/camera/simulation.h"
#include "simulate/camera/stretch.h"
#include "simulate/materials/scene.h"
#include "simulate/materials/strata.h"
#include "simulate/motion/course.h"
#include "simulate/random.h"
#include "simulate/scenes/road_surface.h"
#include "simulate/scenes/vehicle.h"

// What the haul road and the mine share.
namespace highwall::simulate {

// A course in the open that a vehicle drives, and the scene about it as far as it is built.
struct Terrain {
  // stretches: of one lap of the course.
  Terrain(Course line, std::vector<Stretch> hard_parts, const VehicleOptions& rover,
          std::uint64_t seed);

  // For one more thing at random.
  std::uint32_t Seed() { return static_cast<std::uint32_t>(random.Bits()); }

  VehicleOptions vehicle;
  Course course;
  std::vector<Stretch> stretches;
  RandomSequence random;
  RoadSurface surface;
  Strata strata;
  Scene scene;
};

// What the vehicle sees on its laps once the scene is complete and lit by the sun.
Simulation MakeSimulation(Terrain terrain, const SimulationOptions& options);

// Indices of the textures of a scene in the open.
struct TerrainTextures {
  int gravel = 0;  // (x, y) in the world
  int rock = 0;    // (s, height) on faces of `strata`
  int stone = 0;   // of boulders
};

// half_extent [m]: of the ground about the origin.  lowest, highest [m]: of the faces.
TerrainTextures AddTerrainTextures(const Eigen::Vector2d& half_extent, double lowest,
                                   double highest, Terrain* terrain);

// The ground along the course from `right` to `left` metres beside it.
void AddRoad(double right, double left, int texture, Terrain* terrain);

}  // namespace highwall::simulate
