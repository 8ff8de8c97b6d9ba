// The programs of docs/tutorial_factor.md, between the pairs of marks.
// [tutorial]
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

// Where the body is. prior: what is known before, with a standard deviation of 10 m and 0.01 rad.
highwall::Pose Locate(const std::vector<Range>& ranges, const Eigen::Vector3d& antenna_B,
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
// [/tutorial]

// [tutorial]
#include <random>

#include <gtest/gtest.h>
#include <highwall/core/testing/jacobian_check.h>

const Eigen::Vector3d kAntenna(0.3, -0.1, 0.5);

TEST(BeaconRange, JacobianMatchesCentralDifferences) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto vector = [&] {
    return Eigen::Vector3d(normal(random), normal(random), normal(random));
  };
  const highwall::PoseManifold manifold;
  for (int i = 0; i < 100; ++i) {
    const highwall::Pose T_WB = highwall::Pose::FromTangent(3.0 * vector(), vector());
    const BeaconRange factor(4.0, 5.0 * vector(), kAntenna, 0.1);
    const std::vector<double> block(T_WB.data(), T_WB.data() + highwall::Pose::kSize);
    const auto check = highwall::testing::CheckJacobians(factor, {block}, {&manifold});
    EXPECT_TRUE(check) << check.message;
  }
}

TEST(BeaconRange, FindsTheBodyByFourBeacons) {
  const highwall::Pose truth = highwall::Pose::FromTangent({1.0, 2.0, 0.5}, {0.0, 0.0, 0.7});
  std::vector<Range> ranges;
  for (const highwall::Point& beacon : {highwall::Point(0, 0, 3), highwall::Point(9, 0, 1),
                                        highwall::Point(0, 9, 0), highwall::Point(9, 9, 4)}) {
    ranges.push_back({beacon, (truth * kAntenna - beacon).norm()});
  }
  const highwall::Pose prior =
      truth.Plus((Eigen::Matrix<double, 6, 1>() << 1, -2, 1, 0, 0, 0).finished());
  const highwall::Pose found = Locate(ranges, kAntenna, prior);
  // The prior, 2.4 m off and known to 10 m, pulls by (0.05 m / 10 m)^2 of its error.
  EXPECT_LT((found.p() - truth.p()).norm(), 1e-3);
}
// [/tutorial]

TEST(BeaconRange, AnEchoMovesTheBodyByLessThanItsRange) {
  const highwall::Pose truth;
  std::vector<Range> ranges;
  for (const highwall::Point& beacon :
       {highwall::Point(9, 0, 1), highwall::Point(-9, 0, 0), highwall::Point(0, 9, 0),
        highwall::Point(0, -9, 2), highwall::Point(0, 0, 9)}) {
    ranges.push_back({beacon, (truth * kAntenna - beacon).norm()});
  }
  ranges[0].distance += 3.0;
  EXPECT_LT((Locate(ranges, kAntenna, truth).p() - truth.p()).norm(), 0.3);
}

TEST(BeaconRange, SaysNothingAtTheBeacon) {
  const BeaconRange factor(1.0, {0, 0, 0}, {0, 0, 0}, 0.1);
  const highwall::Pose T_WB;
  const double* block = T_WB.data();
  double r = 1.0;
  std::array<double, 7> J;
  J.fill(1.0);
  double* jacobian = J.data();
  EXPECT_TRUE(factor.Evaluate(&block, &r, &jacobian));
  EXPECT_EQ(r, 0.0);
  EXPECT_EQ(J, (std::array<double, 7>{}));
  EXPECT_THROW(BeaconRange(1.0, {0, 0, 0}, {0, 0, 0}, 0.0), highwall::InvalidArgument);
}
