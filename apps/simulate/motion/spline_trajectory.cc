#include "simulate/motion/spline_trajectory.h"

#include <array>
#include <cmath>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall::simulate {
namespace {

using Basis = std::array<double, 3>;

// Cumulative basis of the cubic B-spline (Eq. 4), and its derivatives in u.
Basis CumulativeBasis(double u) {
  return {(5 + u * (3 + u * (-3 + u))) / 6, (1 + u * (3 + u * (3 - 2 * u))) / 6, u * u * u / 6};
}
Basis CumulativeBasisRate(double u) {
  return {(1 + u * (-2 + u)) / 2, (1 + u * (2 - 2 * u)) / 2, u * u / 2};
}
Basis CumulativeBasisAcceleration(double u) {
  return {u - 1, 1 - 2 * u, u};
}

}  // namespace

SplineTrajectory::SplineTrajectory(std::vector<Pose> control, double period)
    : control_(std::move(control)), period_(period) {
  HIGHWALL_REQUIRE(control_.size() >= 4, "SplineTrajectory: needs at least 4 control poses");
  HIGHWALL_REQUIRE(std::isfinite(period) && period > 0.0,
                   "SplineTrajectory: period must be positive");
}

SplineTrajectory::Place SplineTrajectory::PlaceOf(double t) const {
  const double knot =
      (t / period_ - std::floor(t / period_)) * static_cast<double>(control_.size());
  const auto first = static_cast<std::size_t>(knot);
  return {first, knot - static_cast<double>(first)};
}

Pose SplineTrajectory::T_WC(double t) const {
  const Place place = PlaceOf(t);
  const Basis basis = CumulativeBasis(place.u);
  Eigen::Vector3d p = Control(place.first).p();
  Eigen::Quaterniond q = Control(place.first).q();
  for (std::size_t j = 0; j < basis.size(); ++j) {
    const Pose& from = Control(place.first + j);
    const Pose& to = Control(place.first + j + 1);
    p += basis[j] * (to.p() - from.p());
    q = q * so3::Exp(basis[j] * so3::Log(from.q().conjugate() * to.q()));
  }
  return Pose(q, p);
}

CameraMotion SplineTrajectory::MotionAt(double t) const {
  const Place place = PlaceOf(t);
  const double rate = static_cast<double>(control_.size()) / period_;  // du/dt
  const Basis basis = CumulativeBasis(place.u);
  const Basis d_basis = CumulativeBasisRate(place.u);
  const Basis dd_basis = CumulativeBasisAcceleration(place.u);
  CameraMotion motion;
  motion.T_WC = T_WC(t);
  for (std::size_t j = 0; j < basis.size(); ++j) {
    const Pose& from = Control(place.first + j);
    const Pose& to = Control(place.first + j + 1);
    const Eigen::Vector3d step = to.p() - from.p();
    motion.v_WC += rate * d_basis[j] * step;
    motion.a_WC += rate * rate * dd_basis[j] * step;
    // Each factor Exp(b theta) rotates the preceding ones and adds a rate about its own axis.
    const Eigen::Vector3d theta = so3::Log(from.q().conjugate() * to.q());
    const Eigen::Quaterniond back = so3::Exp(-basis[j] * theta);
    motion.w_C = back * motion.w_C + rate * d_basis[j] * theta;
    motion.alpha_C = back * motion.alpha_C + rate * d_basis[j] * motion.w_C.cross(theta) +
                     rate * rate * dd_basis[j] * theta;
  }
  return motion;
}

}  // namespace highwall::simulate
