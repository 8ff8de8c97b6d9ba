#include "support/pose_twins.h"

#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/manifolds.h>
#include <highwall/core/prior.h>
#include <highwall/core/relative_pose.h>

#include "random_states.h"

// Compares the analytic factors on poses with their autodiff twins.
namespace highwall::pose_twins_test {
namespace {

using RowMajor = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;

// Returns the residual, then the Jacobians in the tangent space of poses.
Eigen::MatrixXd Linearize(const ceres::CostFunction& cost,
                          const std::vector<const double*>& poses) {
  const auto count = static_cast<Eigen::Index>(poses.size());
  std::vector<RowMajor> J(poses.size(), RowMajor(6, 7));
  std::vector<double*> jacobians;
  for (RowMajor& j : J) jacobians.push_back(j.data());
  Eigen::Matrix<double, 6, 1> r;
  EXPECT_TRUE(cost.Evaluate(poses.data(), r.data(), jacobians.data()));
  Eigen::MatrixXd all(6, 1 + 6 * count);
  all.col(0) = r;
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
    PoseManifold().PlusJacobian(poses[static_cast<std::size_t>(i)], plus.data());
    all.middleCols<6>(1 + 6 * i) = J[static_cast<std::size_t>(i)] * plus;
  }
  return all;
}

TEST(PoseTwins, FactorsEqualTheirTwinsToRounding) {
  RandomStates random(31);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Matrix<double, 6, 6> W = random.Matrix<6>();
    const Pose a = random.RandomPose(2.0, 1.5), b = random.RandomPose(2.0, 1.5);
    const Pose Z = a.Inverse() * b * random.RandomPose(0.5, 2.0);
    // The tolerance covers rounding, which the twin's coefficients amplify by cancellation at small
    // angles.
    const auto expect_equal = [](const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
      EXPECT_LT((x - y).cwiseAbs().maxCoeff(), 1e-10 * (1.0 + y.cwiseAbs().maxCoeff()));
    };
    expect_equal(Linearize(PosePrior(a, W), {b.data()}),
                 Linearize(*Make(twins::PosePrior{a, W}), {b.data()}));
    expect_equal(Linearize(RelativePose(Z, W), {a.data(), b.data()}),
                 Linearize(*Make(twins::RelativePose{Z, W}), {a.data(), b.data()}));
  }
}

}  // namespace
}  // namespace highwall::pose_twins_test
