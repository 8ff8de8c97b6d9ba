#include <highwall/core/pose.h>

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall {
namespace {

// Calibration files contain matrices with four digits or more.
constexpr double kMaxOrthogonalityError = 1e-3;

}  // namespace

Pose::Pose(const Eigen::Quaterniond& q_AB, const Eigen::Vector3d& p_AB) {
  HIGHWALL_REQUIRE(p_AB.allFinite() && q_AB.coeffs().allFinite(),
                   "Pose: position and quaternion must be finite");
  const double norm = q_AB.norm();
  HIGHWALL_REQUIRE(norm > 1e-12, "Pose: the quaternion must not be zero");
  HIGHWALL_REQUIRE(std::isfinite(norm),
                   "Pose: the norm of the quaternion is too large for a double");
  Eigen::Map<Eigen::Vector3d> p(data());
  Eigen::Map<Eigen::Vector4d> q(data() + 3);
  p = p_AB;
  q = q_AB.coeffs() / norm;
}

Pose Pose::FromMatrix(const Eigen::Matrix4d& T) {
  HIGHWALL_REQUIRE(T.allFinite(), "Pose::FromMatrix: the matrix must be finite");
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  HIGHWALL_REQUIRE(error < kMaxOrthogonalityError && R.determinant() > 0.0,
                   "Pose::FromMatrix: the upper left block must be a rotation");
  return Pose(Eigen::Quaterniond(R), T.topRightCorner<3, 1>());
}

Pose Pose::FromBlock(const double* block) {
  return Pose(Eigen::Quaterniond(block[6], block[3], block[4], block[5]),
              Eigen::Vector3d(block[0], block[1], block[2]));
}

Pose Pose::FromTangent(const Eigen::Vector3d& p_AB, const Eigen::Vector3d& theta_AB) {
  return Pose(so3::Exp(theta_AB), p_AB);
}

Eigen::Matrix4d Pose::Matrix() const {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = R();
  T.topRightCorner<3, 1>() = p();
  return T;
}

Pose Pose::Inverse() const {
  const Eigen::Quaterniond q_BA = q().conjugate();
  return Pose(q_BA, -(q_BA * p()));
}

Pose Pose::operator*(const Pose& T_BC) const {
  return Pose(q() * T_BC.q(), q() * T_BC.p() + p());
}

Eigen::Vector3d Pose::operator*(const Eigen::Vector3d& p_B) const {
  return q() * p_B + p();
}

Pose Pose::Plus(const Eigen::Matrix<double, 6, 1>& d) const {
  return Pose(q() * so3::Exp(d.tail<3>()), p() + d.head<3>());
}

double Pose::Angle() const {
  return 2.0 * std::atan2(q().vec().norm(), std::abs(q().w()));
}

bool Pose::IsFinite() const {
  return std::all_of(data_.begin(), data_.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace highwall
