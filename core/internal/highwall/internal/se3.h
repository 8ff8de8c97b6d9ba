#pragma once

#include <Eigen/Core>

#include <highwall/core/pose.h>

// The group of rigid transforms. Tangent vectors are [rho | theta], translation [m] before rotation
// [rad], and act on the right: T Exp(tau). They differ from the tangents of PoseManifold, which
// updates position and rotation separately: p <- p + dp, R <- R Exp(dtheta) is T Exp([R^T dp |
// dtheta]) to first order. Source: Sola, Deray, Atchuthan, "A micro Lie theory for state estimation
// in robotics", 2018, equation numbers below.
namespace [[gnu::visibility("default")]] highwall {
namespace se3 {

using Tangent = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Exp(tau) (Eq. 172).
Pose Exp(const Tangent& tau);

// Inverse of Exp, |theta| <= pi (Eq. 173).
Tangent Log(const Pose& T);

// Ad_T: T Exp(tau) = Exp(Ad_T tau) T (Eq. 175).
Matrix6 Adjoint(const Pose& T);

// Jr^-1: Log(Exp(tau) Exp(d)) ~ tau + Jr^-1(tau) d (Eq. 179-180); |theta| < 2 pi.
Matrix6 RightJacobianInverse(const Tangent& tau);

}  // namespace se3
}  // namespace highwall
