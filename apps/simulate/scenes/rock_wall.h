#pragma once

#include "simulate/materials/scene.h"
#include "simulate/materials/strata.h"
#include "simulate/motion/course.h"
#include "simulate/scenes/road_surface.h"

namespace highwall::simulate {

// Face of bedded rock along a whole course.
struct RockWallOptions {
  bool left = false;         // of the course; otherwise right of it
  double toe = 1.55;         // [m] from the course to the foot of the face
  double lean = 0.2;         // [m/m] backward inclination
  double bottom = -0.4;      // [m] height of its lower edge above the course
  double top = 2.0;          // [m] height of its crest in the world,
  double top_swing = 0.25;   // [m] and its variation
  double bench = 1.5;        // [m] width of the ledge on top
  double spacing = 0.06;     // [m] of the mesh
  int rock = 0, ground = 0;  // textures: (s, height) on the face, (x, y) on the ledge
  bool dusty = true;         // close enough to the road to be covered with its dust
};

// Adds the face and the ledge behind its crest. Faces do not follow the slope of the course: beds
// are horizontal.
void AddRockWall(const Course& course, const RoadSurface& surface, const Strata& strata,
                 const RockWallOptions& options, Scene* scene);

}  // namespace highwall::simulate
