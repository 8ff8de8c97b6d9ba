#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "simulate/materials/scene.h"

namespace highwall::simulate {

// Two rooms in one scene, without a way from one to the other, that were furnished from one
// catalogue: a few models of cupboards, shelves, tables, boxes and pictures, each several times in
// both rooms and alike to the last print and grain, but in another order, at other distances and on
// walls of other lengths. Walls, floor and ceiling are of one make, their grain is not. The seed
// draws the catalogue, the sizes and the arrangements.
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
