#include "simulate/spline_trajectory.h"

#include <array>
#include <cmath>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall::simulate {

SplineTrajectory::SplineTrajectory(std::vector<Pose> control, double period)
    : control_(std::move(control)), period_(period) {
  HIGHWALL_REQUIRE(control_.size() >= 4, "SplineTrajectory: needs at least 4 control poses");
  HIGHWALL_REQUIRE(std::isfinite(period) && period > 0.0,
                   "SplineTrajectory: period must be positive");
}

Pose SplineTrajectory::T_WC(double t) const {
  const std::size_t n = control_.size();
  const double knot = (t / period_ - std::floor(t / period_)) * static_cast<double>(n);
  const auto i = static_cast<std::size_t>(knot);
  const double u = knot - static_cast<double>(i);
  // The cumulative basis of the cubic B-spline (Eq. 4).
  const std::array<double, 3> basis = {(5 + u * (3 + u * (-3 + u))) / 6,
                                       (1 + u * (3 + u * (3 - 2 * u))) / 6, u * u * u / 6};
  const Pose* previous = &control_[i % n];
  Eigen::Vector3d p = previous->p();
  Eigen::Quaterniond q = previous->q();
  for (std::size_t j = 0; j < basis.size(); ++j) {
    const Pose* next = &control_[(i + j + 1) % n];
    p += basis[j] * (next->p() - previous->p());
    q = q * so3::Exp(basis[j] * so3::Log(previous->q().conjugate() * next->q()));
    previous = next;
  }
  return Pose(q, p);
}

}  // namespace highwall::simulate
