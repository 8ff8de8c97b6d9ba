#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <highwall/core/pose.h>
#include <highwall/core/so3.h>

// Covariances [m^2, rad^2] of poses, of a translation and a rotation along the axes of the camera,
// so that they hold however the map moves.
namespace highwall {

using PoseCovariance = Eigen::Matrix<double, 6, 6>;

// Returns the derivative of the tangent of T_WC = T_WK T_KC, along the axes of C, by that of T_WK,
// along those of K.
inline PoseCovariance AdjointOf(const Pose& T_CK) {
  const Eigen::Matrix3d R_CK = T_CK.R();
  PoseCovariance J = PoseCovariance::Zero();
  J.topLeftCorner<3, 3>() = J.bottomRightCorner<3, 3>() = R_CK;
  J.topRightCorner<3, 3>() = so3::Hat(T_CK.p()) * R_CK;
  return J;
}

// Returns a covariance of K as it acts on a pose C that K carries.
inline PoseCovariance CarriedTo(const Pose& T_CK, const PoseCovariance& covariance_K) {
  const PoseCovariance J = AdjointOf(T_CK);
  return J * covariance_K * J.transpose();
}

// Returns the information by landmarks or pixels with what a covariance of each for itself leaves
// out: their errors are not independent (VisualNoise::scale). Open directions get a metre and a
// radian: no keyframe is farther from its neighbours.
inline PoseCovariance InflatedInformation(const PoseCovariance& information) {
  constexpr double kCorrelation = 4.0;
  constexpr double kLeast = 1.0;  // [1/m^2], [1/rad^2]
  return information / kCorrelation + kLeast * PoseCovariance::Identity();
}

// Returns, in each direction, the lower of a covariance and that of the information: the estimate
// is that of the image where it knows more, and the other does not add to it.
inline PoseCovariance LowerCovariance(const PoseCovariance& covariance,
                                      const PoseCovariance& information) {
  const PoseCovariance L = covariance.llt().matrixL();
  const Eigen::SelfAdjointEigenSolver<PoseCovariance> eigen(L.transpose() * information * L);
  const PoseCovariance LV = L * eigen.eigenvectors();
  return LV * eigen.eigenvalues().cwiseMax(1.0).cwiseInverse().asDiagonal() * LV.transpose();
}

}  // namespace highwall
