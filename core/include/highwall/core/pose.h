#pragma once

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <highwall/core/abi.h>

namespace [[gnu::visibility("default")]] highwall {

class PoseManifold;

// A rigid transform T_AB, p_A = R_AB p_B + p_AB: the pose of frame B in frame A.
//
// Seven contiguous doubles [p_x p_y p_z q_x q_y q_z q_w] (metres, unit Hamilton quaternion): the
// order of a TUM trajectory line, usable directly as a Ceres parameter block with PoseManifold.
class Pose {
 public:
  static constexpr int kSize = 7;
  using Manifold = PoseManifold;

  Pose() : data_{0, 0, 0, 0, 0, 0, 1} {}
  // q_AB is normalised. Throws InvalidArgument if an argument or |q_AB| is not finite or q_AB zero.
  Pose(const Eigen::Quaterniond& q_AB, const Eigen::Vector3d& p_AB);

  static Pose Identity() { return Pose(); }
  // T: rigid; its rotation becomes a unit quaternion. Throws as above, and if the upper left block
  // is not a rotation (to 1e-3).
  static Pose FromMatrix(const Eigen::Matrix4d& T);
  // block: [p q] as stored; q is normalised. Throws as above.
  static Pose FromBlock(const double* block);
  // Position and rotation Exp(theta_AB).
  static Pose FromTangent(const Eigen::Vector3d& p_AB, const Eigen::Vector3d& theta_AB);

  Eigen::Vector3d p() const { return Eigen::Map<const Eigen::Vector3d>(data()); }
  Eigen::Quaterniond q() const { return Eigen::Map<const Eigen::Quaterniond>(data() + 3); }
  Eigen::Matrix3d R() const { return q().toRotationMatrix(); }
  Eigen::Matrix4d Matrix() const;

  double* data() { return data_.data(); }
  const double* data() const { return data_.data(); }

  // T_BA.
  Pose Inverse() const;
  // T_AC = T_AB * T_BC.
  Pose operator*(const Pose& T_BC) const;
  // p_A = T_AB * p_B.
  Eigen::Vector3d operator*(const Eigen::Vector3d& p_B) const;
  // p <- p + d[0..2], R <- R Exp(d[3..5]): the retraction of PoseManifold.
  Pose Plus(const Eigen::Matrix<double, 6, 1>& d) const;

  // Rotation angle [rad], in [0, pi].
  double Angle() const;
  bool IsFinite() const;

 private:
  std::array<double, kSize> data_;
};

}  // namespace highwall
