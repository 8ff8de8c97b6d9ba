#include <highwall/core/marginalization.h>

#include <cmath>
#include <vector>

#include <ceres/problem.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <highwall/core/error.h>

namespace highwall::information_loss_test {
namespace {

// r = w (x_i - x_j), through the square-root prior, which takes any linear row.
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
  // x0 - x1, x0 - x1 - x2 in a chain with unit weights, nothing absolute, reference sigma s.
  double x[3] = {0, 0, 0};
  ceres::Problem problem;
  Link(&problem, 1.0, &x[0], &x[1]);
  Link(&problem, 1.0, &x[1], &x[2]);
  const std::vector<std::vector<double*>> candidates = {{&x[0]}, {&x[1]}, {&x[2]}};
  const double s = 3.0;
  const std::vector<double> loss = InformationLoss(problem, candidates, {.reference_sigma = s});
  ASSERT_EQ(loss.size(), 3u);
  // Without an end, nothing is lost: it says nothing of the others. The middle one ties the ends
  // together with information 1/2: det(I + s^2 [[.5, -.5], [-.5, .5]]) = 1 + s^2.
  EXPECT_NEAR(loss[0], 0.0, 1e-12);
  EXPECT_NEAR(loss[1], 0.5 * std::log(1.0 + s * s), 1e-12);
  EXPECT_NEAR(loss[2], 0.0, 1e-12);
}

TEST(InformationLoss, CountsWhatLandmarksTellOfTheOthers) {
  // Two states see one landmark, a third sees it as well: it adds something to what ties them.
  double x[3] = {0, 0, 0}, landmark = 0.0;
  ceres::Problem problem;
  for (double& state : x) Link(&problem, 2.0, &state, &landmark);
  Anchor(&problem, 1.0, &landmark);
  const std::vector<std::vector<double*>> candidates = {{&x[0]}, {&x[1]}, {&x[2]}};
  const double s = 2.0;
  const std::vector<double> loss = InformationLoss(problem, candidates, {.reference_sigma = s});
  // Dense arithmetic: information of x1, x2 with and without the rows of x0.
  const auto marginal = [](double of_landmark) {
    const Eigen::Vector2d w(4.0, 4.0);
    return Eigen::Matrix2d(Eigen::Matrix2d(w.asDiagonal()) - w * w.transpose() / of_landmark);
  };
  const auto half_log_det = [s](const Eigen::Matrix2d& information) {
    return 0.5 * std::log((Eigen::Matrix2d::Identity() + s * s * information).determinant());
  };
  // x0 with its own row is unknown beside: marginalized, it takes the row with it.
  EXPECT_NEAR(loss[0], half_log_det(marginal(9.0)) - half_log_det(marginal(9.0)), 1e-12);
  // With something known of x0, its row tells of the landmark.
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
  with(0, 0) = 1.0 / 1.0 * 0.5 + 1.0;  // x1 is known with variance 1, x2 from it with 2
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
