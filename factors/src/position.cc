#include <highwall/factors/position.h>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

namespace highwall {

PositionFactor::PositionFactor(const Eigen::Vector3d& p_G, const Eigen::Vector3d& l,
                               const Eigen::Matrix3d& sqrt_information)
    : p_G_(p_G), l_(l), W_(sqrt_information) {
  HIGHWALL_REQUIRE(p_G.allFinite(), "PositionFactor: the position must be finite");
  HIGHWALL_REQUIRE(l.allFinite(), "PositionFactor: the lever arm must be finite");
  HIGHWALL_REQUIRE(sqrt_information.allFinite(), "PositionFactor: sqrt_information must be finite");
}

bool PositionFactor::Evaluate(double const* const* parameters, double* residuals,
                              double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> p_WB(parameters[kPose]), p_GW(parameters[kFrame]);
  const Eigen::Map<const Eigen::Quaterniond> q_WB(parameters[kPose] + 3);
  const Eigen::Map<const Eigen::Quaterniond> q_GW(parameters[kFrame] + 3);
  const Eigen::Matrix3d R_WB = q_WB.toRotationMatrix(), R_GW = q_GW.toRotationMatrix();
  const Eigen::Vector3d l_W = R_WB * l_ + p_WB;  // measured point in W

  Eigen::Map<Eigen::Vector3d> r(residuals);
  r = W_ * (R_GW * l_W + p_GW - p_G_);  // Eq. 1
  if (!r.allFinite()) return false;
  if (jacobians == nullptr) return true;

  const Eigen::Matrix3d WR = W_ * R_GW;
  Eigen::Matrix<double, 3, 6> J;
  if (jacobians[kPose] != nullptr) {  // Eq. 2
    J << WR, -WR * R_WB * so3::Hat(l_);
    PoseManifold::Lift<3>(parameters[kPose], J, jacobians[kPose]);
  }
  if (jacobians[kFrame] != nullptr) {  // Eq. 3
    J << W_, -WR * so3::Hat(l_W);
    PoseManifold::Lift<3>(parameters[kFrame], J, jacobians[kFrame]);
  }
  return true;
}

}  // namespace highwall
