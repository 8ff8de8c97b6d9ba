#pragma once

#include <array>

#include <Eigen/Core>

#include <highwall/core/abi.h>

namespace highwall {

class UnitDirectionManifold;

// A direction in space: a unit vector, three contiguous doubles, and a Ceres parameter block under
// UnitDirectionManifold as it stands. The direction of gravity, n_W, is (0, 0, -1) unless
// estimated.
class UnitDirection {
 public:
  static constexpr int kSize = 3;
  using Manifold = UnitDirectionManifold;

  UnitDirection() : data_{0, 0, -1} {}
  // v is normalised. Throws InvalidArgument if it is not finite or zero.
  explicit UnitDirection(const Eigen::Vector3d& v);

  Eigen::Vector3d vector() const { return Eigen::Map<const Eigen::Vector3d>(data()); }

  double* data() { return data_.data(); }
  const double* data() const { return data_.data(); }

 private:
  std::array<double, kSize> data_;
};

}  // namespace highwall
