#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <highwall/core/pose.h>

#include "simulate/materials/scene.h"
#include "simulate/materials/texture.h"
#include "simulate/random.h"

// Furniture of rooms.
namespace highwall::simulate {

// Wall seen from inside: x to the right along it, y into it, z up; the origin is in the middle of
// its foot. Boxes placed on it face the room.
struct Wall {
  Pose T_WL;
  double length = 0.0;  // [m]
};

// Returns the wall of a room about `middle` seen from there after a rotation by yaw [rad] from +y
// to the left, `distance` [m] away.
Wall MakeWall(double yaw, double distance, double length,
              const Eigen::Vector3d& middle = Eigen::Vector3d::Zero());

// Builds a scene of furniture; random properties are drawn sequentially, piece by piece.
class Furnisher {
 protected:
  // First draws its woods, paints and cardboard.
  explicit Furnisher(std::uint64_t seed);

  std::uint32_t Seed() { return static_cast<std::uint32_t>(random_.Bits()); }
  // Returns the index of the texture.
  int AddNoise(const Colour& colour, double contrast, double wavelength, int octaves);
  int AddMasonry(MasonryOptions options);

  // Adds the wall itself, `height` [m] high, with its skirting and cornice.
  void AddWall(const Wall& wall, double height, int texture);
  // Adds a box with its back on the wall. xz: position of the middle of its foot along the wall and
  // above the floor.
  void AddOn(const Wall& wall, const Eigen::Vector2d& xz, const Eigen::Vector3d& size,
             const BoxTextures& box);
  // Adds a free-standing box, its centre `out` metres from the wall, rotated by yaw.
  void AddFree(const Wall& wall, const Eigen::Vector3d& x_out_z, const Eigen::Vector3d& size,
               double yaw, const BoxTextures& box);
  // Adds a framed print with its centre within 5 cm of (x, z).
  void AddPicture(const Wall& wall, const Eigen::Vector2d& xz, const Eigen::Vector2d& size,
                  bool notice);
  void AddTable(const Wall& wall, double x, const Eigen::Vector3d& size);
  void AddCardboardBox(const Wall& wall, const Eigen::Vector3d& x_out_z,
                       const Eigen::Vector3d& size);
  void AddCupboard(const Wall& wall, double x, const Eigen::Vector3d& size, int rows, int columns);
  // Adds boards between two sides, with rows of books of different depths.
  void AddBookshelf(const Wall& wall, double x, const Eigen::Vector3d& size, int shelves);

  RandomSequence random_;
  Scene scene_;
  int wood_ = 0, dark_ = 0, white_ = 0, metal_ = 0, cardboard_ = 0;  // textures

 private:
  void MakeMaterials();
};

}  // namespace highwall::simulate
