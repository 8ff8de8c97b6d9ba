#include <highwall/core/prior.h>

#include <cmath>

#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

namespace highwall {

PosePrior::PosePrior(const Pose& T_0, const Eigen::Matrix<double, 6, 6>& sqrt_information)
    : T_0_(T_0), W_(sqrt_information) {
  HIGHWALL_REQUIRE(T_0.IsFinite(), "PosePrior: the pose must be finite");
  HIGHWALL_REQUIRE(sqrt_information.allFinite(), "PosePrior: sqrt_information must be finite");
}

bool PosePrior::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> p(parameters[0]);
  const Eigen::Map<const Eigen::Quaterniond> q(parameters[0] + 3);
  const Eigen::Vector3d theta = so3::Log(T_0_.q().conjugate() * q);

  Eigen::Matrix<double, 6, 1> e;
  e << p - T_0_.p(), theta;
  Eigen::Map<Eigen::Matrix<double, 6, 1>> r(residuals);
  r = W_ * e;  // Eq. 1

  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Matrix<double, 6, 6> dr_dpose = W_;
    dr_dpose.rightCols<3>() = W_.rightCols<3>() * so3::RightJacobianInverse(theta);  // Eq. 2
    PoseManifold::Lift<6>(parameters[0], dr_dpose, jacobians[0]);
  }
  return true;
}

DirectionPrior::DirectionPrior(const UnitDirection& n_0, double sigma)
    : W_(UnitDirectionManifold::Basis(n_0.data()).transpose() / sigma) {
  HIGHWALL_REQUIRE(std::isfinite(sigma) && sigma > 0.0, "DirectionPrior: sigma must be positive");
}

bool DirectionPrior::Evaluate(double const* const* parameters, double* residuals,
                              double** jacobians) const {
  Eigen::Map<Eigen::Vector2d> r(residuals);
  r = W_ * Eigen::Map<const Eigen::Vector3d>(parameters[0]);  // Eq. 5
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> J(jacobians[0]);
    J = W_;
  }
  return true;
}

GravityPrior::GravityPrior(double sigma) : inverse_sigma_(1.0 / sigma) {
  HIGHWALL_REQUIRE(std::isfinite(sigma) && sigma > 0.0, "GravityPrior: sigma must be positive");
}

bool GravityPrior::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const Eigen::Map<const Eigen::Quaterniond> q(parameters[0] + 3);
  const Eigen::Matrix3d R = q.toRotationMatrix();
  Eigen::Map<Eigen::Vector2d> r(residuals);
  r = inverse_sigma_ * R.topRightCorner<2, 1>();  // Eq. 6
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Matrix<double, 2, 6> J = Eigen::Matrix<double, 2, 6>::Zero();
    J.col(3) = -inverse_sigma_ * R.block<2, 1>(0, 1);  // Eq. 7
    J.col(4) = inverse_sigma_ * R.block<2, 1>(0, 0);
    PoseManifold::Lift<2>(parameters[0], J, jacobians[0]);
  }
  return true;
}

}  // namespace highwall
