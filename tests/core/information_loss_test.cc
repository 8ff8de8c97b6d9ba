#include <highwall/core/marginalization.h>

#include <cmath>
#include <vector>

#include <ceres/problem.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <highwall/core/error.h>

namespace highwall::information_loss_test {
namespace {

// r = w (x_i - x_j), implemented by the square-root prior, which accepts any linear row.
void Link(ceres::Problem* problem, double w, double* x_i, double* x_j) {
  const Eigen::RowVector2d row(w, -w);
  problem->AddResidualBlock(
      new MarginalPrior({{{0.0}, nullptr}, {{0.0}, nullptr}}, row, Eigen::VectorXd::Zero(1)),
      nullptr, x_i, x_j);
}
void Anchor(ceres::Problem* problem, double w, double* x) {
  problem->AddResidualBlock(
      new MarginalPrior({{{0.0}, nullptr}}, Eigen::MatrixXd::Constant(1, 1, w),
                        Eigen::VectorXd::Zero(1)),
      nullptr, x);
}

TEST(InformationLoss, OfAChainComputedByHand) {
  // Chain x0 - x1 - x2 with unit weights, without an absolute measurement, with reference sigma s.
  double x[3] = {0, 0, 0};
  ceres::Problem problem;
  Link(&problem, 1.0, &x[0], &x[1]);
  Link(&problem, 1.0, &x[1], &x[2]);
  const std::vector<std::vector<double*>> candidates = {{&x[0]}, {&x[1]}, {&x[2]}};
  const double s = 3.0;
  const std::vector<double> loss = InformationLoss(problem, candidates, {.reference_sigma = s});
  ASSERT_EQ(loss.size(), 3u);
  // Removing an end state loses nothing, because it gives no information on the others. The middle
  // state links the ends with information 1/2: det(I + s^2 [[.5, -.5], [-.5, .5]]) = 1 + s^2.
  EXPECT_NEAR(loss[0], 0.0, 1e-12);
  EXPECT_NEAR(loss[1], 0.5 * std::log(1.0 + s * s), 1e-12);
  EXPECT_NEAR(loss[2], 0.0, 1e-12);
}

TEST(InformationLoss, CountsInformationThroughSharedLandmarks) {
  // Three states observe one landmark, so each may add information to the constraint between the
  // others.
  double x[3] = {0, 0, 0}, landmark = 0.0;
  ceres::Problem problem;
  for (double& state : x) Link(&problem, 2.0, &state, &landmark);
  Anchor(&problem, 1.0, &landmark);
  const std::vector<std::vector<double*>> candidates = {{&x[0]}, {&x[1]}, {&x[2]}};
  const double s = 2.0;
  const std::vector<double> loss = InformationLoss(problem, candidates, {.reference_sigma = s});
  // Dense computation: information of x1 and x2 with and without the rows of x0.
  const auto marginal = [](double of_landmark) {
    const Eigen::Vector2d w(4.0, 4.0);
    return Eigen::Matrix2d(Eigen::Matrix2d(w.asDiagonal()) - w * w.transpose() / of_landmark);
  };
  const auto half_log_det = [s](const Eigen::Matrix2d& information) {
    return 0.5 * std::log((Eigen::Matrix2d::Identity() + s * s * information).determinant());
  };
  // x0 has only this one row and is otherwise unknown: marginalizing it consumes the row.
  EXPECT_NEAR(loss[0], half_log_det(marginal(9.0)) - half_log_det(marginal(9.0)), 1e-12);
  // Once x0 has a prior, its row carries information on the landmark.
  Anchor(&problem, 3.0, &x[0]);
  const double through_x0 = 1.0 / (1.0 / 4.0 + 1.0 / 9.0);
  const std::vector<double> anchored = InformationLoss(problem, candidates, {.reference_sigma = s});
  EXPECT_NEAR(anchored[0], half_log_det(marginal(9.0 + through_x0)) - half_log_det(marginal(9.0)),
              1e-12);
  EXPECT_GT(anchored[0], 0.01);
}

TEST(InformationLoss, TakesTheBlocksOfACandidateTogetherAndFixedOnesAsKnown) {
  double x[4] = {0, 0, 0, 0};
  ceres::Problem problem;
  Link(&problem, 1.0, &x[0], &x[1]);
  Link(&problem, 1.0, &x[1], &x[2]);
  Link(&problem, 1.0, &x[2], &x[3]);
  Anchor(&problem, 1.0, &x[0]);
  const std::vector<std::vector<double*>> candidates = {{&x[0], &x[1]}, {&x[2]}, {&x[3]}};
  const double s = 10.0;
  // x0 and x1 anchor x2 with variance 3.
  Eigen::Matrix2d with, without;
  with << 1.0 / 3.0 + 1.0, -1.0, -1.0, 1.0;
  without << 1.0, -1.0, -1.0, 1.0;
  const auto half_log_det = [s](const Eigen::Matrix2d& information) {
    return 0.5 * std::log((Eigen::Matrix2d::Identity() + s * s * information).determinant());
  };
  EXPECT_NEAR(InformationLoss(problem, candidates, {.reference_sigma = s})[0],
              half_log_det(with) - half_log_det(without), 1e-12);
  problem.SetParameterBlockConstant(&x[0]);
  with(0, 0) = 1.0 / 1.0 * 0.5 + 1.0;  // x1 is known with variance 1, x2 through it with variance 2
  EXPECT_NEAR(InformationLoss(problem, candidates, {.reference_sigma = s})[0],
              half_log_det(with) - half_log_det(without), 1e-12);
}

TEST(InformationLoss, RefusesBadArguments) {
  double x = 0.0, stranger = 0.0;
  ceres::Problem problem;
  Anchor(&problem, 1.0, &x);
  const std::vector<std::vector<double*>> twice = {{&x}, {&x}}, unknown = {{&stranger}};
  EXPECT_THROW(InformationLoss(problem, twice), InvalidArgument);
  EXPECT_THROW(InformationLoss(problem, unknown), InvalidArgument);
  EXPECT_THROW(InformationLoss(problem, {}, {.reference_sigma = 0.0}), InvalidArgument);
  EXPECT_TRUE(InformationLoss(problem, {}).empty());
}

}  // namespace
}  // namespace highwall::information_loss_test
