#pragma once

#include <type_traits>

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/pose.h>
#include <highwall/core/variable.h>

namespace [[gnu::visibility("default")]] highwall {

// Prior on a pose.
//
//   r = W [ p - p_0 | Log(q_0^-1 q) ]                             docs/factors/prior.md, Eq. 1
//
// Blocks:  0: T  pose (7, PoseManifold); r is in its tangent coordinates [m, rad] at T_0
// Domain:  everywhere; the Jacobian is discontinuous where the rotation from T_0 is pi.
class PosePrior final : public ceres::SizedCostFunction<6, 7> {
 public:
  using Variables = VariableList<Pose>;

  // T_0: the expected pose. sqrt_information: W, 6 x 6, W^T W = Sigma^-1 (SqrtInformation()).
  // Throws InvalidArgument if an argument is not finite.
  PosePrior(const Pose& T_0, const Eigen::Matrix<double, 6, 6>& sqrt_information);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Pose T_0_;
  const Eigen::Matrix<double, 6, 6> W_;
};

// Prior on a direction, such as gravity.
//
//   r = B(n_0)^T n / sigma                                        docs/factors/prior.md, Eq. 5
//
// Blocks:  0: n  direction (3, UnitDirectionManifold); B as defined there
// Domain:  less than 90 deg from n_0: |r| is the sine of the angle; zero gradient at n = -n_0.
class DirectionPrior final : public ceres::SizedCostFunction<2, 3> {
 public:
  using Variables = VariableList<UnitDirection>;

  // sigma: [rad] > 0. Throws InvalidArgument if it is not.
  DirectionPrior(const UnitDirection& n_0, double sigma);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Eigen::Matrix<double, 2, 3> W_;
};

// Gravity alignment of two frames that both have their z axis up, such as a gravity-aligned world
// and a GPS frame; it does not constrain the heading and the position between them.
//
//   r = [x y](R e_z) / sigma                                      docs/factors/prior.md, Eq. 6
//
// Blocks:  0: T  pose (7, PoseManifold), of one frame in the other
// Domain:  less than 90 deg between the axes: |r| is the sine of the angle over sigma.
class GravityPrior final : public ceres::SizedCostFunction<2, 7> {
 public:
  using Variables = VariableList<Pose>;

  // sigma: [rad] > 0. Throws InvalidArgument if it is not.
  explicit GravityPrior(double sigma);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const double inverse_sigma_;
};

// Prior on a Euclidean variable of N doubles: a point, a velocity, a bias, a scalar.
//
//   r = W (x - x_0)                                               docs/factors/prior.md, Eq. 3
//
// Blocks:  0: x  (N, Euclidean); Variable<double> where N = 1
template <int N>
class VectorPrior final : public ceres::SizedCostFunction<N, N> {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  using Variables = VariableList<std::conditional_t<N == 1, double, Vector>>;

  // x_0: the expected value. sqrt_information: W, N x N, W^T W = Sigma^-1 (SqrtInformation()).
  // Throws InvalidArgument if an argument is not finite.
  VectorPrior(const Vector& x_0, const Matrix& sqrt_information) : x_0_(x_0), W_(sqrt_information) {
    HIGHWALL_REQUIRE(x_0.allFinite(), "VectorPrior: x_0 must be finite");
    HIGHWALL_REQUIRE(sqrt_information.allFinite(), "VectorPrior: sqrt_information must be finite");
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Vector> x(parameters[0]);
    Eigen::Map<Vector> r(residuals);
    r = W_ * (x - x_0_);  // Eq. 3
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      // Row i of the row-major Jacobian is contiguous.
      for (int i = 0; i < N; ++i) {
        Eigen::Map<Eigen::Matrix<double, 1, N>> row(jacobians[0] + i * N);
        row = W_.row(i);  // Eq. 4
      }
    }
    return true;
  }

 private:
  const Vector x_0_;
  const Matrix W_;
};

}  // namespace highwall
