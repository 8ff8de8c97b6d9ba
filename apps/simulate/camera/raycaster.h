#pragma once

#include <array>
#include <memory>

#include <Eigen/Core>

#include "simulate/materials/scene.h"

namespace highwall::simulate {

// Ray caster that finds the first triangle on a ray, with a search tree over a mesh (Embree 3 or
// 4). Thread-safe.
class Raycaster {
 public:
  static constexpr int kNone = -1;
  static constexpr int kPacket = 8;

  // The mesh is copied. Throws std::runtime_error if the tree cannot be built.
  explicit Raycaster(const Mesh& mesh);
  ~Raycaster();
  Raycaster(Raycaster&&) noexcept;
  Raycaster& operator=(Raycaster&&) noexcept;

  // Returns the index of the first triangle on origin + k direction, k > 0, or kNone. World frame,
  // [m]; the direction may have any length.
  int FirstTriangle(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
  // Does the same for kPacket directions from one origin, which is faster.
  std::array<int, kPacket> FirstTriangles(
      const Eigen::Vector3d& origin, const std::array<Eigen::Vector3d, kPacket>& directions) const;
  // Whether nothing is hit between the origin and origin + reach direction.
  bool IsFree(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double reach) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace highwall::simulate
