#pragma once

#include <cstdint>
#include <functional>

#include <Eigen/Core>

#include "simulate/materials/scene.h"
#include "simulate/motion/course.h"
#include "simulate/scenes/road_surface.h"

// Objects along a haul road: installations and fallen rocks.
namespace highwall::simulate {

// Adds a round tube from s_begin to s_end [m] along the course; place(s): left of the course and
// above it [m].
void AddTube(const Course& course, double s_begin, double s_end, double radius, int texture,
             const std::function<Eigen::Vector2d(double s)>& place, Scene* scene);

struct RoadsideOptions {
  double right = -1.1, left = 2.65;  // [m] lateral positions of the markers
  double marker_spacing = 3.2;       // [m]
  double sign_spacing = 8.5;         // [m]
  double pole_spacing = 4.5;         // [m] of the cable, on the left
  bool pipe = true;                  // along the left
};

// Adds striped marker posts, signs, a cable on poles, a pipe; none in low-texture stretches.
void AddRoadside(const Course& course, const RoadSurface& surface, const RoadsideOptions& options,
                 std::uint64_t seed, Scene* scene);

struct DebrisOptions {
  double road = 2.0;                  // [m] half width with pebbles
  double pebbles = 22.0;              // per metre of road
  double boulders = 2.2;              // per metre, along both sides
  double right = -1.05, left = 2.55;  // [m] boulders begin there
  double reach = 0.55;                // [m] and extend so far beyond
};

// Adds pebbles on the road and boulders next to it; few in low-texture stretches. rock: texture.
void AddDebris(const Course& course, const RoadSurface& surface, const DebrisOptions& options,
               int rock, std::uint64_t seed, Scene* scene);

}  // namespace highwall::simulate
