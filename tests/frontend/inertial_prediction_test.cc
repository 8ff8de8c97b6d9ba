#include <algorithm>

#include <gtest/gtest.h>

#include <highwall/core/so3.h>

#include "inertial_drive.h"

namespace highwall::inertial_prediction_test {
namespace {

using testing::Drive;
using testing::kBias;
using testing::kStep;
using testing::kTilted;

TEST(InertialPrediction, AgreesWithTheTruthWithinItsCovariance) {
  Drive drive({.bias = kBias, .T_WN = kTilted});
  drive.Until(4.0);
  double sum = 0.0;
  constexpr int kImages = 20;
  for (int i = 0; i < kImages; ++i) {
    drive.Until(drive.Stamp());
    ASSERT_TRUE(drive.prediction);
    Eigen::Matrix<double, 6, 1> e;
    const Pose truth = drive.Truth(drive.last), T = drive.prediction->T_WC;
    e << truth.p() - T.p(), so3::Log(T.q().conjugate() * truth.q());
    sum += (drive.prediction->sqrt_information * e).squaredNorm();
  }
  // Its covariance is inflated four times, which makes 6 / 4 of 6; neighbours are correlated.
  EXPECT_LT(sum / kImages, 6.0);
  EXPECT_GT(sum / kImages, 0.1);
}

TEST(InertialPrediction, GivesTheMotionAtTheImageNotTheMeanOfTheStepToIt) {
  Drive drive({.bias = kBias, .T_WN = kTilted});
  drive.Until(5.0);
  double v = 0.0, omega = 0.0, omega_of_step = 0.0;
  for (int i = 0; i < 20; ++i) {
    drive.Until(drive.Stamp());
    ASSERT_TRUE(drive.prediction && drive.prediction->motion);
    constexpr double h = 1e-3;  // [s] the error of the difference is of order h^2
    const Twist truth = Twist::Between(
        drive.Truth(drive.last - h).Inverse() * drive.Truth(drive.last + h), 2.0 * h);
    const Twist step =
        Twist::Between(drive.Truth(drive.last - kStep).Inverse() * drive.Truth(drive.last), kStep);
    v = std::max(v, (drive.prediction->motion->v - truth.v).norm());
    omega = std::max(omega, (drive.prediction->motion->omega - truth.omega).norm());
    omega_of_step = std::max(omega_of_step, (step.omega - truth.omega).norm());
  }
  // One reading has a noise of 0.0035 rad/s an axis (2.4e-4 rad/s/sqrt(Hz), 200 Hz); images of 1 mm
  // every 0.1 s give a velocity noise of 14 mm/s.
  EXPECT_LT(omega, 0.01);
  EXPECT_LT(v, 0.03);
  EXPECT_GT(omega_of_step, 5.0 * omega);
}

}  // namespace
}  // namespace highwall::inertial_prediction_test
