#include <highwall/frontend/inertial/visual_pose.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include <highwall/core/error.h>

namespace highwall {

VisualPose MakeVisualPose(const Pose& T_WC, const Eigen::Matrix<double, 6, 6>& information,
                          const Eigen::Matrix<double, 6, 1>& gradient, double error,
                          const VisualNoise& noise) {
  constexpr double kOpen = 1e-6;       // of the common noise's information: too little for a step
  constexpr double kRounding = 1e-12;  // of the largest eigenvalue: rounding error
  using TangentVector = Eigen::Matrix<double, 6, 1>;
  using TangentMatrix = Eigen::Matrix<double, 6, 6>;
  // In units of the common noise, whose covariance is then I.
  TangentVector unit;
  unit << Eigen::Vector3d::Constant(noise.position), Eigen::Vector3d::Constant(noise.rotation);
  const double scale = noise.scale * std::max(error, noise.min_error);
  const TangentMatrix H = unit.asDiagonal() * information * unit.asDiagonal() / scale;
  const Eigen::SelfAdjointEigenSolver<TangentMatrix> eigen(H);
  const TangentVector slope =
      eigen.eigenvectors().transpose() * (unit.cwiseProduct(gradient) / scale);
  const double nothing = kRounding * eigen.eigenvalues()(5);  // in ascending order
  TangentVector step, sqrt_information;
  for (int i = 0; i < 6; ++i) {
    const double h = eigen.eigenvalues()(i);
    step(i) = h > kOpen ? -slope(i) / h : 0.0;
    // From the covariance 1 / h + 1; a row of zeros carries no information.
    sqrt_information(i) = h > nothing ? std::sqrt(h / (1.0 + h)) : 0.0;
  }
  VisualPose visual;
  visual.T_WC = T_WC.Plus(unit.cwiseProduct(eigen.eigenvectors() * step));
  visual.sqrt_information = sqrt_information.asDiagonal() * eigen.eigenvectors().transpose() *
                            unit.cwiseInverse().asDiagonal();
  return visual;
}

VisualPose Moved(const VisualPose& visual, const Pose& T_new_old) {
  VisualPose moved{T_new_old * visual.T_WC, visual.sqrt_information};
  // In the tangent of a pose, positions rotate with the world and rotations do not.
  moved.sqrt_information.leftCols<3>() =
      visual.sqrt_information.leftCols<3>() * T_new_old.R().transpose();
  return moved;
}

}  // namespace highwall
