#include <highwall/core/manifolds.h>

#include <cmath>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall {
namespace {

using ConstQuaternion = Eigen::Map<const Eigen::Quaterniond>;

void PlusRotation(const double* q, const double* dtheta, double* q_plus) {
  const Eigen::Quaterniond step = so3::Exp(Eigen::Map<const Eigen::Vector3d>(dtheta));
  Eigen::Map<Eigen::Quaterniond> out(q_plus);
  // Normalised here, so that rounding cannot drift over many solver steps.
  out = (ConstQuaternion(q) * step).normalized();
}

void MinusRotation(const double* y, const double* x, double* dtheta) {
  Eigen::Map<Eigen::Vector3d> out(dtheta);
  out = so3::Log(ConstQuaternion(x).conjugate() * ConstQuaternion(y));
}

}  // namespace

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  for (int i = 0; i < 3; ++i) x_plus_delta[i] = x[i] + delta[i];
  PlusRotation(x + 3, delta + 3, x_plus_delta + 3);
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  J.topLeftCorner<3, 3>().setIdentity();
  // dq/dtheta is a quarter of the transposed lift: lift * lift^T = 4 I for a unit quaternion.
  J.bottomRightCorner<4, 3>() = 0.25 * RotationLift(x + 3).transpose();
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  for (int i = 0; i < 3; ++i) y_minus_x[i] = y[i] - x[i];
  MinusRotation(y + 3, x + 3, y_minus_x + 3);
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.bottomRightCorner<3, 4>() = RotationLift(x + 3);
  return true;
}

bool LineManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  PlusRotation(x, delta, x_plus_delta);
  const double c = std::cos(delta[3]), s = std::sin(delta[3]);
  const double w1 = x[4] * c - x[5] * s, w2 = x[4] * s + x[5] * c;
  const double norm = std::hypot(w1, w2);
  x_plus_delta[4] = w1 / norm;
  x_plus_delta[5] = w2 / norm;
  return true;
}

bool LineManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 6, 4, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  J.topLeftCorner<4, 3>() = 0.25 * PoseManifold::RotationLift(x).transpose();
  J(4, 3) = -x[5];
  J(5, 3) = x[4];
  return true;
}

bool LineManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  MinusRotation(y, x, y_minus_x);
  y_minus_x[3] = std::atan2(x[4] * y[5] - x[5] * y[4], x[4] * y[4] + x[5] * y[5]);
  return true;
}

bool LineManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 4, 6, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  J.topLeftCorner<3, 4>() = PoseManifold::RotationLift(x);
  J(3, 4) = -x[5];
  J(3, 5) = x[4];
  return true;
}

Eigen::Matrix<double, 3, 2> UnitDirectionManifold::Basis(const double* x) {
  const double sign = std::copysign(1.0, x[2]);
  const double a = -1.0 / (sign + x[2]), b = x[0] * x[1] * a;
  Eigen::Matrix<double, 3, 2> basis;
  basis << 1.0 + sign * x[0] * x[0] * a, b,  //
      sign * b, sign + x[1] * x[1] * a,      //
      -sign * x[0], -x[1];
  return basis;
}

bool UnitDirectionManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const Eigen::Map<const Eigen::Vector3d> n(x);
  const Eigen::Map<const Eigen::Vector2d> d(delta);
  const double angle = d.norm();
  const double sinc = angle < 1e-4 ? 1.0 - angle * angle / 6.0 : std::sin(angle) / angle;
  Eigen::Map<Eigen::Vector3d> out(x_plus_delta);
  out = (std::cos(angle) * n + sinc * (Basis(x) * d)).normalized();
  return true;
}

bool UnitDirectionManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 3, 2, Eigen::RowMajor>> J(jacobian);
  J = Basis(x);
  return true;
}

bool UnitDirectionManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Eigen::Map<const Eigen::Vector3d> n(x), m(y);
  const Eigen::Vector2d across = Basis(x).transpose() * m;
  const double along = n.dot(m), sine = across.norm();
  Eigen::Map<Eigen::Vector2d> out(y_minus_x);
  // angle / sine -> 1 / along for small angles; opposite directions have no unique step.
  const bool small = sine < 1e-4 * std::abs(along) && along > 0.0;
  const double tangent2 = small ? sine * sine / (along * along) : 0.0;
  out = across * (small ? (1.0 - tangent2 / 3.0) / along : std::atan2(sine, along) / sine);
  if (sine == 0.0 && along < 0.0) out = Eigen::Vector2d(std::acos(-1.0), 0.0);
  return true;
}

bool UnitDirectionManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> J(jacobian);
  J = Basis(x).transpose();
  return true;
}

UnitDirection::UnitDirection(const Eigen::Vector3d& v) {
  HIGHWALL_REQUIRE(v.allFinite(), "UnitDirection: the vector must be finite");
  const double norm = v.norm();
  HIGHWALL_REQUIRE(norm > 1e-12, "UnitDirection: the vector must not be zero");
  Eigen::Map<Eigen::Vector3d> n(data());
  n = v / norm;
}

}  // namespace highwall
