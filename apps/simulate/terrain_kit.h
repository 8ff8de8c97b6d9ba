#pragma once

#include <vector>

#include <Eigen/Core>

#include "simulate/course.h"
#include "simulate/imu_simulator.h"
#include "simulate/random.h"
#include "simulate/road_surface.h"
#include "simulate/scene.h"
#include "simulate/strata.h"
#include "simulate/stretch.h"

// What the haul road and the mine share.
namespace highwall::simulate {

// Indices of the textures of a scene in the open.
struct TerrainTextures {
  int gravel = 0;  // (x, y) in the world
  int rock = 0;    // (s, height) on faces of `strata`
  int stone = 0;   // of boulders
};

// half_extent [m]: of the ground about the origin.  lowest, highest [m]: of the faces.
TerrainTextures AddTerrainTextures(const Strata& strata, const Eigen::Vector2d& half_extent,
                                   double lowest, double highest, RandomSequence* random,
                                   Scene* scene);

// The ground along a course from `right` to `left` metres beside it.
void AddRoad(const Course& course, const RoadSurface& surface, double right, double left,
             int texture, Scene* scene);

// The shaking of an IMU: a little everywhere, all of it in the bumpy and the blurred stretches.
// stretches: of one lap, period [s] of the lap.
VibrationIntensity VibrationOn(std::vector<Stretch> stretches, double period);

}  // namespace highwall::simulate
