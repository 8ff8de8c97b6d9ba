#pragma once

#include <memory>
#include <vector>

#include <ceres/loss_function.h>
#include <ceres/sized_cost_function.h>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/core/so3.h>

// The distance from an antenna on the body to a beacon whose place is known.
//
//   r = (|p_WB + R_WB p_BA - p_W| - z) / sigma
//
// Blocks:  0: T_WB  pose (7, PoseManifold)
// Domain:  antenna and beacon at least 1 mm apart; nearer r = 0, J = 0 and Evaluate is true.
class BeaconRange final : public ceres::SizedCostFunction<1, 7> {
 public:
  using Variables = highwall::VariableList<highwall::Pose>;

  // z [m]: measured. p_W [m]: the beacon. p_BA [m]: the antenna on the body. sigma [m] > 0.
  // Throws InvalidArgument if it is not.
  BeaconRange(double z, const highwall::Point& p_W, const Eigen::Vector3d& p_BA, double sigma)
      : z_(z), p_W_(p_W), p_BA_(p_BA), inverse_sigma_(1.0 / sigma) {
    HIGHWALL_REQUIRE(sigma > 0.0, "BeaconRange: sigma must be positive");
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> p_WB(parameters[0]);
    const Eigen::Matrix3d R_WB =
        Eigen::Map<const Eigen::Quaterniond>(parameters[0] + 3).toRotationMatrix();
    const Eigen::Vector3d way = p_WB + R_WB * p_BA_ - p_W_;
    const double range = way.norm();
    const bool known = range >= 1e-3;
    residuals[0] = known ? (range - z_) * inverse_sigma_ : 0.0;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    // In the tangent [dp dtheta], then once for all lifted to the seven numbers of the block.
    Eigen::Matrix<double, 1, 6> dr_dpose = Eigen::Matrix<double, 1, 6>::Zero();
    if (known) {
      const Eigen::RowVector3d dr_dp = inverse_sigma_ / range * way.transpose();
      dr_dpose << dr_dp, -dr_dp * R_WB * highwall::so3::Hat(p_BA_);
    }
    highwall::PoseManifold::Lift<1>(parameters[0], dr_dpose, jacobians[0]);
    return true;
  }

 private:
  const double z_;
  const highwall::Point p_W_;
  const Eigen::Vector3d p_BA_;
  const double inverse_sigma_;
};

struct Range {
  highwall::Point beacon_W;  // [m]
  double distance;           // [m]
};

// Returns T_WB. antenna_B [m]: the antenna on the body. prior: what is known before, with a
// standard deviation of 10 m and 0.01 rad. Throws InvalidArgument if the ranges cannot be
// evaluated.
inline highwall::Pose Locate(const std::vector<Range>& ranges, const Eigen::Vector3d& antenna_B,
                             const highwall::Pose& prior) {
  using namespace highwall;
  FactorGraph graph;
  const Variable<Pose> T_WB = graph.AddVariable(prior);
  Eigen::Matrix<double, 6, 1> information;  // square root of
  information << 0.1, 0.1, 0.1, 100, 100, 100;
  graph.AddFactor(std::make_unique<PosePrior>(prior, information.asDiagonal()), T_WB);
  const auto loss = std::make_shared<ceres::HuberLoss>(2.0);  // sigma: echoes are no reason to move
  for (const Range& range : ranges) {
    graph.AddFactor(std::make_unique<BeaconRange>(range.distance, range.beacon_W, antenna_B, 0.05),
                    loss, T_WB);
  }
  const SolveSummary summary = graph.Solve();
  HIGHWALL_REQUIRE(summary.IsUsable(), summary.message);
  return graph.Value(T_WB);
}
