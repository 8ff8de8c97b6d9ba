#include "consistency.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include <highwall/core/so3.h>
#include <highwall/factors/adaptive_imu_weight.h>

namespace highwall::bench {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

}  // namespace

NormalizedErrors Normalize(const InertialEstimate& estimate, double gravity_sigma,
                           const ImuState& truth, const ImuBias& true_bias, const Pose& T_WV) {
  const Eigen::Matrix3d R = estimate.state.T_WB.R(), R_true = truth.T_WB.R();
  NormalizedErrors errors;

  const Eigen::Vector3d up = R.transpose().col(2), true_up = R_true.transpose().col(2);
  const double tilt = std::atan2(up.cross(true_up).norm(), up.dot(true_up));
  errors.tilt = tilt * tilt / (gravity_sigma * gravity_sigma) / 2.0;

  const Eigen::Vector3d v = R.transpose() * estimate.state.v_WB;
  const Eigen::Vector3d v_error = v - R_true.transpose() * truth.v_WB;
  Eigen::Matrix<double, 3, 6> dv;  // with respect to theta and v
  dv << so3::Hat(v), R.transpose();
  const Eigen::Matrix3d P_v = dv * estimate.covariance.block<6, 6>(3, 3) * dv.transpose();
  errors.velocity = v_error.dot(P_v.llt().solve(v_error)) / 3.0;

  const Pose T_WB = T_WV * truth.T_WB;
  Vector6 d;
  d << estimate.state.T_WB.p() - T_WB.p(), so3::Log(T_WB.q().conjugate() * estimate.state.T_WB.q());
  const Matrix6 P_pose = estimate.covariance.topLeftCorner<6, 6>();
  errors.pose = d.dot(P_pose.llt().solve(d)) / 6.0;

  const Vector6 b = estimate.bias - true_bias;
  const Matrix6 P_bias = estimate.covariance.bottomRightCorner<6, 6>();
  errors.bias = b.dot(P_bias.llt().solve(b)) / 6.0;
  return errors;
}

std::string ConsistencyLine(const std::vector<Scores>& runs) {
  constexpr std::pair<const char*, int> kErrors[] = {
      {"tilt", 2}, {"velocity", 3}, {"pose", 6}, {"bias", 6}};
  std::string line;
  for (const auto& [name, dof] : kErrors) {
    double sum = 0.0;
    int count = 0;
    for (const Scores& scores : runs) {
      const auto found = scores.find(fmt::format("end_{}_chi2_per_dof", name));
      if (found == scores.end()) continue;
      sum += found->second;
      ++count;
    }
    if (count < 2) return "";
    const int all = dof * count;
    line +=
        fmt::format("{}{} {:.2f} ({:.2f} to {:.2f})", line.empty() ? "" : ", ", name, sum / count,
                    ChiSquaredQuantile(0.025, all) / all, ChiSquaredQuantile(0.975, all) / all);
  }
  return line;
}

}  // namespace highwall::bench
