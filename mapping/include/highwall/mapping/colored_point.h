#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

namespace highwall {

// A point of a surface.
struct ColoredPoint {
  Eigen::Vector3f p = Eigen::Vector3f::Zero();       // [m]
  std::array<std::uint8_t, 3> rgb{255, 255, 255};    // white where there is no colour image
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, towards the sensor; 0 where unknown
};

}  // namespace highwall
