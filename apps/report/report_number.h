#pragma once

#include <cmath>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

namespace highwall::apps {

// Rounds to a multiple of `step`: numbers on a page need only visible digits.
inline double Rounded(double value, double step) {
  return std::round(value / step) / std::round(1.0 / step);
}

// p: [m], rounded to tenths of a millimetre.
inline nlohmann::json PositionJson(const Eigen::Vector3d& p) {
  return {Rounded(p.x(), 1e-4), Rounded(p.y(), 1e-4), Rounded(p.z(), 1e-4)};
}

}  // namespace highwall::apps
