#include "inertial/innovation.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <highwall/core/sqrt_information.h>

namespace highwall::innovation_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const Pose kPose = Pose::FromTangent({1, -2, 3}, {0.3, -0.2, 0.5});

Matrix6 RandomCovariance(std::mt19937& rng, double sigma) {
  std::normal_distribution<double> normal;
  const Matrix6 A = Matrix6::NullaryExpr([&] { return normal(rng); });
  return sigma * sigma * (A * A.transpose() / 6.0 + 0.1 * Matrix6::Identity());
}

VisualPose See(const Pose& T_WC, const Matrix6& covariance) {
  return {T_WC, SqrtInformation(covariance)};
}

TEST(SquaredInnovation, IsChiSquaredOfSixWhereBothAreAsTheyState) {
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;
  const auto noise = [&](const Matrix6& covariance) -> Vector6 {
    return covariance.llt().matrixL() * Vector6::NullaryExpr([&] { return normal(rng); });
  };
  constexpr int kRuns = 2000;
  double sum = 0.0;
  for (int i = 0; i < kRuns; ++i) {
    const Matrix6 of_readings = RandomCovariance(rng, 3e-3), of_image = RandomCovariance(rng, 1e-3);
    const auto squared = SquaredInnovation({kPose.Plus(noise(of_readings)), of_readings},
                                           See(kPose.Plus(noise(of_image)), of_image));
    ASSERT_TRUE(squared);
    sum += *squared;
  }
  // The mean of chi-squared of 6: four of its deviations, sqrt(12 / n).
  EXPECT_NEAR(sum / kRuns, 6.0, 4.0 * std::sqrt(12.0 / kRuns));
}

TEST(SquaredInnovation, IsNoneWhereTheImageLeavesADirectionOpen) {
  VisualPose visual = See(kPose, 1e-6 * Matrix6::Identity());
  visual.sqrt_information.row(2).setZero();
  EXPECT_FALSE(SquaredInnovation({kPose, 1e-6 * Matrix6::Identity()}, visual));
}

// The camera moves steadily except for a centimetre along x in the image's pose; the readings are
// off by `readings` along y, with a covariance of a millimetre and a milliradian.
bool Contradicted(double readings, double squared_innovation, bool known_bad = false) {
  const auto along = [](int axis, double by) { return kPose.Plus(by * Vector6::Unit(axis)); };
  return AreReadingsContradicted(squared_innovation,
                                 {along(1, readings), 1e-6 * Matrix6::Identity()}, along(0, 0.01),
                                 kPose, known_bad);
}

TEST(AreReadingsContradicted, BeyondTenDeviationsAndFurtherFromASteadyCameraThanTheImage) {
  EXPECT_TRUE(Contradicted(0.02, 101.0));
  EXPECT_FALSE(Contradicted(0.02, 99.0));
  EXPECT_FALSE(Contradicted(0.005, 1e4)) << "the image departs further: it may be wrong itself";
  EXPECT_FALSE(Contradicted(0.02, std::nan("")));
}

TEST(AreReadingsContradicted, LessIsEnoughWhereTheIntervalBeforeWas) {
  EXPECT_TRUE(Contradicted(0.02, 17.0, true));
  EXPECT_FALSE(Contradicted(0.02, 16.0, true));
  EXPECT_FALSE(Contradicted(0.005, 17.0, true));
}

}  // namespace
}  // namespace highwall::innovation_test
