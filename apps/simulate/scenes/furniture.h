#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <highwall/core/pose.h>

#include "simulate/materials/scene.h"
#include "simulate/materials/texture.h"
#include "simulate/random.h"

// What rooms are furnished with.
namespace highwall::simulate {

// A wall, seen from inside: x to the right along it, y into it, z up; the origin in the middle of
// its foot. Boxes placed here have their front towards the room.
struct Wall {
  Pose T_WL;
  double length = 0.0;  // [m]
};

// The wall of a room about `middle` that somebody there sees who turns by yaw [rad] from +y to the
// left, `distance` [m] away.
Wall MakeWall(double yaw, double distance, double length,
              const Eigen::Vector3d& middle = Eigen::Vector3d::Zero());

// Builds a scene of pieces of furniture; what is random about them is drawn one piece after the
// other.
class Furnisher {
 protected:
  // Draws its woods, paints and cardboard first.
  explicit Furnisher(std::uint64_t seed);

  std::uint32_t Seed() { return static_cast<std::uint32_t>(random_.Bits()); }
  // Returns the index of the texture.
  int AddNoise(const Colour& colour, double contrast, double wavelength, int octaves);
  int AddMasonry(MasonryOptions options);

  // The wall itself, `height` [m] high, with its skirting and cornice.
  void AddWall(const Wall& wall, double height, int texture);
  // A box with its back on the wall; x along the wall and z above the floor of the middle of its
  // foot.
  void AddOn(const Wall& wall, const Eigen::Vector2d& xz, const Eigen::Vector3d& size,
             const BoxTextures& box);
  // A box anywhere, `out` metres from the wall to its middle, turned by yaw.
  void AddFree(const Wall& wall, const Eigen::Vector3d& x_out_z, const Eigen::Vector3d& size,
               double yaw, const BoxTextures& box);
  // A framed print, its middle within 5 cm of (x, z).
  void AddPicture(const Wall& wall, const Eigen::Vector2d& xz, const Eigen::Vector2d& size,
                  bool notice);
  void AddTable(const Wall& wall, double x, const Eigen::Vector3d& size);
  void AddCardboardBox(const Wall& wall, const Eigen::Vector3d& x_out_z,
                       const Eigen::Vector3d& size);
  void AddCupboard(const Wall& wall, double x, const Eigen::Vector3d& size, int rows, int columns);
  // Boards between two sides, rows of books of different depths on them.
  void AddBookshelf(const Wall& wall, double x, const Eigen::Vector3d& size, int shelves);

  RandomSequence random_;
  Scene scene_;
  int wood_ = 0, dark_ = 0, white_ = 0, metal_ = 0, cardboard_ = 0;  // textures

 private:
  void MakeMaterials();
};

}  // namespace highwall::simulate
