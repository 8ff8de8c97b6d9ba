#pragma once

#include <deque>

#include <Eigen/Core>

#include <highwall/core/stamp.h>

namespace highwall {

// Whether the images of the last two seconds agree with a camera at rest: to the readings of an IMU
// a body that creeps at constant speed rests.
//
// The speed is that of the line through the positions, and known as well as these scatter about it.
class VisualRest {
 public:
  // p: the camera in a frame that no correction of the map moves [m]. Stamps ascend.
  void Add(Stamp stamp, const Eigen::Vector3d& p);
  void Clear() { positions_.clear(); }

  // True where there are images over two seconds, and their speed is none: within its sigmas, and
  // less than what the pseudo-measurement of rest could hide.
  bool Agrees() const;

 private:
  struct Position {
    Stamp stamp;
    Eigen::Vector3d p;
  };
  std::deque<Position> positions_;
};

}  // namespace highwall
