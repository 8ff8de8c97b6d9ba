#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "simulate/materials/scene.h"

namespace highwall::simulate {

// Two disconnected rooms in one scene, furnished from one catalogue: a few models of cupboards,
// shelves, tables, boxes and pictures, each several times in both rooms and identical down to print
// and grain, but in another order, at other distances and on walls of other lengths. Walls, floor
// and ceiling have the same materials, but different grain. The seed determines the catalogue, the
// sizes and the arrangements.
struct TwinRooms {
  struct Room {
    Eigen::Vector3d middle;  // [m] of the floor
    Eigen::Vector2d half;    // [m] to the walls
  };
  std::array<Room, 2> rooms;
  Scene scene;
};

TwinRooms MakeTwinRooms(std::uint64_t seed);

}  // namespace highwall::simulate
