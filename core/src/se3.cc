#include <highwall/internal/se3.h>

#include <cmath>

#include <highwall/core/so3.h>

namespace highwall::se3 {
namespace {

// Below this squared angle the closed forms of Q lose digits to cancellation, and the series,
// truncated after the theta^6 terms, is exact to rounding.
constexpr double kSmallAngleSquared = 1e-2;

// Q(rho, theta): the coupling block of the left Jacobian (Sola et al., Eq. 180).
Eigen::Matrix3d CouplingBlock(const Eigen::Vector3d& rho, const Eigen::Vector3d& theta) {
  const double t2 = theta.squaredNorm();
  double a, b, c;  // (t - sin t) / t^3, (1 - t^2/2 - cos t) / t^4, (t - sin t - t^3/6) / t^5
  if (t2 < kSmallAngleSquared) {
    a = 1.0 / 6.0 - t2 * (1.0 / 120.0 - t2 * (1.0 / 5040.0 - t2 / 362880.0));
    b = -1.0 / 24.0 + t2 * (1.0 / 720.0 - t2 * (1.0 / 40320.0 - t2 / 3628800.0));
    c = -1.0 / 120.0 + t2 * (1.0 / 5040.0 - t2 * (1.0 / 362880.0 - t2 / 39916800.0));
  } else {
    const double t = std::sqrt(t2);
    a = (t - std::sin(t)) / (t2 * t);
    b = (1.0 - 0.5 * t2 - std::cos(t)) / (t2 * t2);
    c = (t - std::sin(t) - t2 * t / 6.0) / (t2 * t2 * t);
  }
  const Eigen::Matrix3d P = so3::Hat(rho), T = so3::Hat(theta);
  const Eigen::Matrix3d TP = T * P, PT = P * T, TPT = TP * T;
  return 0.5 * P + a * (TP + PT + TPT) - b * (T * TP + PT * T - 3.0 * TPT) -
         0.5 * (b - 3.0 * c) * (TPT * T + T * TPT);
}

}  // namespace

Pose Exp(const Tangent& tau) {
  const Eigen::Vector3d theta = tau.tail<3>();
  // The left Jacobian of SO(3) is the right Jacobian of -theta.
  return Pose(so3::Exp(theta), so3::RightJacobian(-theta) * tau.head<3>());
}

Tangent Log(const Pose& T) {
  const Eigen::Vector3d theta = so3::Log(T.q());
  Tangent tau;
  tau << so3::RightJacobianInverse(-theta) * T.p(), theta;
  return tau;
}

Matrix6 Adjoint(const Pose& T) {
  const Eigen::Matrix3d R = T.R();
  Matrix6 Ad;
  Ad << R, so3::Hat(T.p()) * R, Eigen::Matrix3d::Zero(), R;
  return Ad;
}

Matrix6 RightJacobianInverse(const Tangent& tau) {
  const Eigen::Vector3d rho = tau.head<3>(), theta = tau.tail<3>();
  const Eigen::Matrix3d J_inverse = so3::RightJacobianInverse(theta);
  Matrix6 out;
  out << J_inverse, -J_inverse * CouplingBlock(-rho, -theta) * J_inverse, Eigen::Matrix3d::Zero(),
      J_inverse;
  return out;
}

}  // namespace highwall::se3
