#include <highwall/core/unit_direction.h>

#include <highwall/core/error.h>

namespace highwall {

UnitDirection::UnitDirection(const Eigen::Vector3d& v) {
  HIGHWALL_REQUIRE(v.allFinite(), "UnitDirection: non-finite vector");
  const double norm = v.norm();
  HIGHWALL_REQUIRE(norm > 1e-12, "UnitDirection: zero vector");
  Eigen::Map<Eigen::Vector3d> n(data());
  n = v / norm;
}

}  // namespace highwall
