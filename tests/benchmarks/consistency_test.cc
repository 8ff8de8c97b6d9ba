// Normalized errors of an estimate by its covariance, as highwall_bench_inertial reports them.
#include "consistency.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <highwall/core/so3.h>

namespace highwall::bench::consistency_test {
namespace {

using Matrix15 = Eigen::Matrix<double, 15, 15>;
using Vector15 = Eigen::Matrix<double, 15, 1>;

// Millimetres, milliradians and the like, all correlated.
Matrix15 SomeCovariance(std::mt19937& rng) {
  std::normal_distribution<double> normal;
  const Matrix15 A = Matrix15::NullaryExpr([&] { return normal(rng); });
  return 1e-6 * (A * A.transpose() + 5.0 * Matrix15::Identity());
}

Pose SomePose(std::mt19937& rng) {
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Eigen::Vector3d::NullaryExpr([&] { return normal(rng); }); };
  return Pose::FromTangent(draw(), draw());
}

// Errors drawn from the covariance have a mean of 1 per degree of freedom, in every part, for any
// pose and tilt of the true world.
TEST(Consistency, IsOneForErrorsDrawnFromTheCovariance) {
  std::mt19937 rng(4);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 4000;
  constexpr double kGravity = 0.01;  // [rad], ten times the uncertainty of rotations in that world
  NormalizedErrors mean;
  for (int i = 0; i < kDraws; ++i) {
    InertialEstimate estimate;
    estimate.covariance = SomeCovariance(rng);
    const Vector15 unit = Vector15::NullaryExpr([&] { return normal(rng); });
    const Vector15 d = estimate.covariance.llt().matrixL() * unit;
    const Eigen::Quaterniond tilt = so3::Exp({kGravity * normal(rng), kGravity * normal(rng), 0.0});
    const Pose T_WV(tilt * so3::Exp({0.0, 0.0, 0.7}), Eigen::Vector3d(3.0, -1.0, 2.0));
    const ImuState truth{SomePose(rng), Eigen::Vector3d(0.4, -0.8, 0.1)};
    const ImuBias bias = ImuBias::Constant(0.01);
    estimate.state.T_WB = (T_WV * truth.T_WB).Plus(d.head<6>());
    estimate.state.v_WB = T_WV.q() * truth.v_WB + d.segment<3>(6);
    estimate.bias = bias + d.tail<6>();
    const NormalizedErrors errors = Normalize(estimate, kGravity, truth, bias, T_WV);
    mean.tilt += errors.tilt / kDraws;
    mean.velocity += errors.velocity / kDraws;
    mean.pose += errors.pose / kDraws;
    mean.bias += errors.bias / kDraws;
  }
  // Four standard deviations of the mean of chi-squared per degree of freedom.
  const auto bound = [](int dof) { return 4.0 * std::sqrt(2.0 / dof / kDraws); };
  EXPECT_NEAR(mean.tilt, 1.0, bound(2) + 0.2);  // plus the squared uncertainty of rotations
  EXPECT_NEAR(mean.velocity, 1.0, bound(3));
  EXPECT_NEAR(mean.pose, 1.0, bound(6));
  EXPECT_NEAR(mean.bias, 1.0, bound(6));
}

TEST(Consistency, ReportsTheMeanOfTheRunsAndTheBoundsOfChance) {
  const auto run = [](double value) {
    return Scores{{"end_tilt_chi2_per_dof", value},
                  {"end_velocity_chi2_per_dof", 1.0},
                  {"end_pose_chi2_per_dof", 1.0},
                  {"end_bias_chi2_per_dof", 1.0}};
  };
  EXPECT_EQ(ConsistencyLine({run(1.0)}), "");
  EXPECT_EQ(ConsistencyLine({run(1.0), Scores{}}), "");
  const std::string line = ConsistencyLine({run(1.0), run(2.0), run(4.5), run(2.5), run(0.0)});
  // Interval of chi-squared with 10 degrees of freedom: 3.25 to 20.5.
  EXPECT_EQ(line.find("tilt 2.00 (0.32 to 2.05), velocity 1.00 ("), 0U) << line;
}

}  // namespace
}  // namespace highwall::bench::consistency_test
