#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/abi.h>

// The rotation group. Tangent vectors are rotation vectors [rad]; quaternions are Hamilton, unit.
// Source: Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics", 2018,
// equation numbers below. Accurate to rounding at small angles and near pi.
namespace [[gnu::visibility("default")]] highwall {
namespace so3 {

// The skew matrix of v: Hat(v) w = v x w.
Eigen::Matrix3d Hat(const Eigen::Vector3d& v);

// Exp(theta): rotation by |theta| about theta (Eq. 132).
Eigen::Quaterniond Exp(const Eigen::Vector3d& theta);

// The rotation vector of q, |Log(q)| <= pi (Eq. 133). q and -q give the same vector.
Eigen::Vector3d Log(const Eigen::Quaterniond& q);

// Jr: Exp(theta + d) ~ Exp(theta) Exp(Jr(theta) d) (Eq. 143).
Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& theta);

// The inverse of RightJacobian (Eq. 144); |theta| < 2 pi.
Eigen::Matrix3d RightJacobianInverse(const Eigen::Vector3d& theta);

}  // namespace so3
}  // namespace highwall
