#pragma once

#include <array>

#include <ceres/manifold.h>
#include <Eigen/Core>

#include <highwall/core/abi.h>

namespace [[gnu::visibility("default")]] highwall {

// Pose block:  double[7] = [ p_x p_y p_z | q_x q_y q_z q_w ]   (class Pose)
// Tangent:     double[6] = [ dp | dtheta ],   p <- p + dp,   R <- R Exp(dtheta).
//
// The quaternion manifolds of Ceres apply the step on the left with half angles; every factor,
// prior and covariance of Highwall is expressed in the step of this manifold.
class PoseManifold final : public ceres::Manifold {
 public:
  static constexpr int kAmbientSize = 7;
  static constexpr int kTangentSize = 6;

  int AmbientSize() const override { return kAmbientSize; }
  int TangentSize() const override { return kTangentSize; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

  // Factors differentiate in the tangent space and call this once per pose block: it writes the
  // row-major ambient Jacobian J (kRows x 7) with J * PlusJacobian(x) == tangent_jacobian.
  template <int kRows>
  static void Lift(const double* x, const Eigen::Matrix<double, kRows, 6>& tangent_jacobian,
                   double* ambient_jacobian) {
    const Eigen::Matrix<double, 3, 4> lift = RotationLift(x + 3);
    Eigen::Map<Eigen::Matrix<double, kRows, 7, Eigen::RowMajor>> out(ambient_jacobian);
    out.template leftCols<3>() = tangent_jacobian.template leftCols<3>();
    out.template rightCols<4>().noalias() =
        (tangent_jacobian.template rightCols<3>() * lift).eval();
  }

  // d(Log(q^-1 y))/dy at y = q, for q = [x y z w]: the rotation part of MinusJacobian.
  static Eigen::Matrix<double, 3, 4> RotationLift(const double* q) {
    const double x = 2.0 * q[0], y = 2.0 * q[1], z = 2.0 * q[2], w = 2.0 * q[3];
    Eigen::Matrix<double, 3, 4> m;
    m << w, z, -y, -x,  //
        -z, w, x, -y,   //
        y, -x, w, -z;
    return m;
  }
};

// Orthonormal line block (Bartoli, Sturm 2005, "Structure-from-motion using lines", section 4.1):
//              double[6] = [ q_x q_y q_z q_w | w_1 w_2 ]   (class OrthonormalLine), U = R(q)
// Tangent:     double[4] = [ dtheta (3) | dphi ],  U <- U Exp(dtheta),  W <- W R2(dphi),
// where R2 is the 2 x 2 rotation and W = [w_1 -w_2; w_2 w_1].
class LineManifold final : public ceres::Manifold {
 public:
  static constexpr int kAmbientSize = 6;
  static constexpr int kTangentSize = 4;

  int AmbientSize() const override { return kAmbientSize; }
  int TangentSize() const override { return kTangentSize; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

  // As PoseManifold::Lift: J (kRows x 6, row major) with J * PlusJacobian(x) == tangent_jacobian.
  template <int kRows>
  static void Lift(const double* x, const Eigen::Matrix<double, kRows, 4>& tangent_jacobian,
                   double* ambient_jacobian) {
    const Eigen::Matrix<double, 3, 4> lift = PoseManifold::RotationLift(x);
    Eigen::Map<Eigen::Matrix<double, kRows, 6, Eigen::RowMajor>> out(ambient_jacobian);
    out.template leftCols<4>().noalias() = (tangent_jacobian.template leftCols<3>() * lift).eval();
    out.col(4) = -x[5] * tangent_jacobian.col(3);
    out.col(5) = x[4] * tangent_jacobian.col(3);
  }
};

// Unit direction block:  double[3] = n, |n| = 1   (class UnitDirection)
// Tangent:               double[2] = d,  n <- cos|d| n + sin|d| / |d| B(n) d,
// a step of |d| radians along a great circle. B(n), 3 x 2, is the orthonormal basis of the plane
// orthogonal to n of Duff et al. 2017, "Building an orthonormal basis, revisited", listing 3; it
// rotates abruptly where n_z changes its sign, and no factor may depend on it.
class UnitDirectionManifold final : public ceres::Manifold {
 public:
  static constexpr int kAmbientSize = 3;
  static constexpr int kTangentSize = 2;

  int AmbientSize() const override { return kAmbientSize; }
  int TangentSize() const override { return kTangentSize; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

  // B(x).
  static Eigen::Matrix<double, 3, 2> Basis(const double* x);

  // As PoseManifold::Lift: J (kRows x 3, row major) with J * PlusJacobian(x) == tangent_jacobian.
  template <int kRows>
  static void Lift(const double* x, const Eigen::Matrix<double, kRows, 2>& tangent_jacobian,
                   double* ambient_jacobian) {
    Eigen::Map<Eigen::Matrix<double, kRows, 3, Eigen::RowMajor>> out(ambient_jacobian);
    out.noalias() = tangent_jacobian * Basis(x).transpose();
  }
};

// A direction in space: a unit vector, three contiguous doubles, usable directly as a Ceres
// parameter block with UnitDirectionManifold. The direction of gravity, n_W, is (0, 0, -1) unless
// it is estimated.
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
