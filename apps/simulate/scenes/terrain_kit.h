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

// Common parts of the haul road and the mine.
namespace highwall::simulate {

// Outdoor course driven by a vehicle, with the scene built so far.
struct Terrain {
  // stretches: of one lap of the course.
  Terrain(Course line, std::vector<Stretch> hard_parts, const VehicleOptions& rover,
          std::uint64_t seed);

  // Returns a seed for one more random object.
  std::uint32_t Seed() { return static_cast<std::uint32_t>(random.Bits()); }

  VehicleOptions vehicle;
  Course course;
  std::vector<Stretch> stretches;
  RandomSequence random;
  RoadSurface surface;
  Strata strata;
  Scene scene;
};

// Simulates the laps of the vehicle, after the scene is complete and lit by the sun.
Simulation MakeSimulation(Terrain terrain, const SimulationOptions& options);

// Texture indices of an outdoor scene.
struct TerrainTextures {
  int gravel = 0;  // (x, y) in the world
  int rock = 0;    // (s, height) on faces of `strata`
  int stone = 0;   // of boulders
};

// half_extent [m]: of the ground about the origin. lowest, highest [m]: of the faces.
TerrainTextures AddTerrainTextures(const Eigen::Vector2d& half_extent, double lowest,
                                   double highest, Terrain* terrain);

// Adds the ground along the course from `right` to `left` metres beside it.
void AddRoad(double right, double left, int texture, Terrain* terrain);

}  // namespace highwall::simulate
