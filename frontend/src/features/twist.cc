#include <highwall/frontend/features/twist.h>

#include <cmath>

#include <highwall/core/so3.h>

namespace highwall {
namespace {

// sin(t) / t, (1 - cos(t)) / t^2 and (t - sin(t)) / t^3 of an angle of rotation.
struct RotationSeries {
  double a, b, c;

  explicit RotationSeries(double squared_angle) {
    const double t2 = squared_angle;
    constexpr double kSmall = 0.01;  // [rad^2] up to which the first five terms are exact
    if (t2 < kSmall) {
      b = (1.0 - t2 / 12.0 * (1.0 - t2 / 30.0 * (1.0 - t2 / 56.0 * (1.0 - t2 / 90.0)))) / 2.0;
      c = (1.0 - t2 / 20.0 * (1.0 - t2 / 42.0 * (1.0 - t2 / 72.0 * (1.0 - t2 / 110.0)))) / 6.0;
      a = 1.0 - t2 * c;
    } else {
      const double t = std::sqrt(t2);
      a = std::sin(t) / t;
      b = (1.0 - std::cos(t)) / t2;
      c = (1.0 - a) / t2;
    }
  }
};

}  // namespace

Twist Twist::Between(const Pose& T_AB, double dt) {
  // p = Jl(theta) rho, where Jl(theta) = Jr(-theta).
  const Eigen::Vector3d theta = so3::Log(T_AB.q());
  return {so3::RightJacobianInverse(-theta) * T_AB.p() / dt, theta / dt};
}

Pose Twist::Over(double dt) const {
  const Eigen::Vector3d theta = dt * omega;
  return Pose(so3::Exp(theta), so3::RightJacobian(-theta) * (dt * v));
}

Eigen::Vector3d Twist::Transform(double dt, const Eigen::Vector3d& p) const {
  const Eigen::Vector3d theta = dt * omega, rho = dt * v;
  const RotationSeries series(theta.squaredNorm());
  const Eigen::Vector3d turned = theta.cross(p), shifted = theta.cross(rho);
  return p + rho + series.a * turned + series.b * (theta.cross(turned) + shifted) +
         series.c * theta.cross(shifted);
}

}  // namespace highwall
