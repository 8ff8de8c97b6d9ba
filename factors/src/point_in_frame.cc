#include <highwall/factors/point_in_frame.h>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

namespace highwall {

PointInFrame::PointInFrame(const Eigen::Vector3d& p_F, const Eigen::Matrix3d& sqrt_information)
    : p_F_(p_F), W_(sqrt_information) {
  HIGHWALL_REQUIRE(p_F.allFinite(), "PointInFrame: the point must be finite");
  HIGHWALL_REQUIRE(sqrt_information.allFinite(), "PointInFrame: sqrt_information must be finite");
}

bool PointInFrame::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> p_WF(parameters[kFrame]), p_W(parameters[kPoint]);
  const Eigen::Map<const Eigen::Quaterniond> q_WF(parameters[kFrame] + 3);
  const Eigen::Matrix3d R_FW = q_WF.toRotationMatrix().transpose();
  const Eigen::Vector3d p_F = R_FW * (p_W - p_WF);  // current position in F

  Eigen::Map<Eigen::Vector3d> r(residuals);
  r = W_ * (p_F - p_F_);  // Eq. 1
  if (!r.allFinite()) return false;
  if (jacobians == nullptr) return true;

  const Eigen::Matrix3d WR = W_ * R_FW;
  if (jacobians[kFrame] != nullptr) {  // Eq. 2
    Eigen::Matrix<double, 3, 6> J;
    J << -WR, W_ * so3::Hat(p_F);
    PoseManifold::Lift<3>(parameters[kFrame], J, jacobians[kFrame]);
  }
  if (jacobians[kPoint] != nullptr) {  // Eq. 3
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> J(jacobians[kPoint]);
    J = WR;
  }
  return true;
}

}  // namespace highwall
