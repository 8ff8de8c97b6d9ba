#include "sensor/images_scale.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/so3.h>

namespace highwall::images_scale_test {
namespace {

constexpr double kPositionSigma = 1e-3;    // [m] of an image
constexpr double kStep = 0.1, kArc = 0.2;  // [s]

// Changes of velocity of `count` arcs, of accelerations of about `motion` [m/s^2] beside gravity,
// by images whose lengths are `scale` times the true ones. The camera turns slowly, and the
// accelerometer has a bias.
AccelerometerFit Draw(unsigned seed, int count, double motion, double scale,
                      double position_sigma = kPositionSigma) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&](double sigma) {
    return Eigen::Vector3d(sigma * normal(rng), sigma * normal(rng), sigma * normal(rng));
  };
  const Eigen::Vector3d gravity(0.0, 0.0, -9.81), bias = vector(0.1);
  Eigen::Quaterniond q_WC = so3::Exp(vector(0.5));
  AccelerometerFit fit;
  Eigen::Vector3d before = vector(position_sigma), here = vector(position_sigma);
  for (int i = 0; i < count; ++i) {
    q_WC = q_WC * so3::Exp(vector(0.05));
    const Eigen::Vector3d acceleration = vector(motion);
    const Eigen::Vector3d force = q_WC.conjugate() * (acceleration - gravity) + bias + vector(0.02);
    const Eigen::Vector3d after = vector(position_sigma);
    const Eigen::Vector3d y = scale * kArc * acceleration + (after - 2.0 * here + before) / kArc;
    before = here;
    here = after;
    AccelerometerFit::Row X = AccelerometerFit::Row::Zero();
    const Eigen::Matrix3d R = q_WC.toRotationMatrix();
    for (int row = 0; row < 3; ++row)
      X.block<3, 3>(0, 3 * row) = kArc * R.col(row) * force.transpose();
    X.block<3, 3>(0, 12) = kArc * Eigen::Matrix3d::Identity();
    X.block<3, 3>(0, 15) = kArc * R;
    fit.Add(y, X, kArc);
  }
  return fit;
}

std::optional<double> ScaleOf(const AccelerometerFit& fit) {
  return ContradictedScale(fit, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero());
}

// Depth that is five times too long makes the errors of the images as much longer: a free fit
// explains two thirds of the changes of velocity, and the scale leaves more than a right one does.
TEST(ContradictedScale, FindsAFarScaleWhoseImagesAreNoisy) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto scale = ScaleOf(Draw(seed, 60, 0.15, 5.0, 0.01));
    ASSERT_TRUE(scale) << seed;
    EXPECT_NEAR(std::log2(*scale), std::log2(5.0), 1.0) << seed;
  }
}

// At a rate of one in a thousand, three and more alarms in 400 draws have a probability of 0.8 %.
TEST(ContradictedScale, RaisesFalseAlarmsAtMostOnceInAThousandDraws) {
  int alarms = 0;
  for (unsigned seed = 1; seed <= 400; ++seed) {
    const double motion = 0.02 * std::exp2(0.5 * (seed % 16));  // up to 3.6 m/s^2
    const double scale = seed % 3 == 0 ? 1.02 : seed % 3 == 1 ? 0.98 : 1.0;
    alarms += ScaleOf(Draw(seed, 25 + static_cast<int>(seed % 75), motion, scale)) ? 1 : 0;
  }
  EXPECT_LE(alarms, 2);
}

TEST(ContradictedScale, FindsWrongUnitsOfTheDepth) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const double scale : {0.1, 0.2, 0.5, 2.0, 5.0, 10.0}) {
      const auto found = ScaleOf(Draw(seed, 42, 2.0, scale));
      ASSERT_TRUE(found) << seed << ", " << scale;
      // Steps of 2^(1/16), and the scatter of 42 arcs.
      EXPECT_NEAR(*found / scale, 1.0, 0.1) << seed;
    }
  }
}

TEST(ContradictedScale, LeavesTwentyPercentToTheEstimateAfterTheRun) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const double scale : {0.83, 1.2}) {
      EXPECT_FALSE(ScaleOf(Draw(seed, 42, 2.0, scale))) << seed << ", " << scale;
    }
  }
}

TEST(ContradictedScale, SaysNothingOfReadingsThatNoScaleExplains) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const AccelerometerFit fit = Draw(seed, 42, 1.0, 1.0);
    const Eigen::Matrix3d turned = so3::Exp(Eigen::Vector3d(0.0, 1.6, 0.0)).toRotationMatrix();
    EXPECT_FALSE(ContradictedScale(fit, turned, Eigen::Vector3d::Zero())) << seed;
  }
}

}  // namespace
}  // namespace highwall::images_scale_test
