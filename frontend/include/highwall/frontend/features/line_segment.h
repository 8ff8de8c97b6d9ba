#pragma once

#include <Eigen/Core>

#include <highwall/core/abi.h>

namespace highwall {

// A segment in an image [px]. As extracted, its brighter side lies to the left of the way from s
// to e as the image is seen (y down), so that the order of the ends means the same in every view.
struct LineSegment {
  Eigen::Vector2f s = Eigen::Vector2f::Zero();
  Eigen::Vector2f e = Eigen::Vector2f::Zero();

  float Length() const;
  // Of the undirected segment [rad], in [0, pi), from x towards y.
  float Angle() const;
  Eigen::Vector2f Midpoint() const;
};

}  // namespace highwall
