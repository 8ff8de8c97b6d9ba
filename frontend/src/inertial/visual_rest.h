#pragma once

#include <deque>

#include <Eigen/Core>

#include <highwall/core/stamp.h>

namespace highwall {

// Tests whether the images of the last two seconds agree with a stationary camera: the readings of
// an IMU do not distinguish a body in slow uniform motion from a stationary one.
//
// The speed is that of a line fitted to the positions; its sigma follows from their scatter.
class VisualRest {
 public:
  // p: the camera's position [m] in a frame that no correction of the map moves. Stamps ascend.
  void Add(Stamp stamp, const Eigen::Vector3d& p);
  void Clear() { positions_.clear(); }

  // Returns true if the images cover two seconds and their speed is not significant: within its
  // sigmas, and below what the zero-velocity pseudo-measurement could hide.
  bool Agrees() const;

 private:
  struct Position {
    Stamp stamp;
    Eigen::Vector3d p;
  };
  std::deque<Position> positions_;
};

}  // namespace highwall
