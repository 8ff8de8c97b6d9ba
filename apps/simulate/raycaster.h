#pragma once

#include <memory>

#include <Eigen/Core>

#include "simulate/scene.h"

namespace highwall::simulate {

// Which triangle does a ray meet first? A search tree over a mesh (Embree 3 or 4). Thread-safe.
class Raycaster {
 public:
  static constexpr int kNone = -1;

  // The mesh is copied. Throws std::runtime_error if the tree cannot be built.
  explicit Raycaster(const Mesh& mesh);
  ~Raycaster();
  Raycaster(Raycaster&&) noexcept;
  Raycaster& operator=(Raycaster&&) noexcept;

  // Index of the first triangle on origin + k direction, k > 0, or kNone. World frame, [m]; the
  // direction may have any length.
  int FirstTriangle(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace highwall::simulate
