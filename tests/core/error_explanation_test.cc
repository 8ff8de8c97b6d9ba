#include <highwall/core/trajectory_error.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall::error_explanation_test {
namespace {

constexpr double kNoise = 1e-3;  // [m] white noise on each axis

// A body that rotates and translates along every axis.
Pose BodyAt(double t) {
  const Eigen::Vector3d p(std::sin(0.7 * t), 0.8 * std::sin(1.1 * t + 1.0),
                          0.5 * std::sin(1.7 * t + 2.0));
  const Eigen::Vector3d turn(0.5 * std::sin(0.9 * t), 0.4 * std::sin(1.3 * t + 0.5), 0.3 * t);
  return Pose(so3::Exp(turn), p);
}

struct Errors {
  double late = 0.0;   // [s] delay of the estimate's stamps
  double scale = 1.0;  // scale of the estimate
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
  Eigen::Vector3d hand_eye = Eigen::Vector3d::Zero();
  double noise = kNoise;
};

// The reference at 120 Hz, from -1 s to 61 s.
Trajectory Reference(const std::function<Pose(double)>& body = BodyAt) {
  Trajectory reference;
  for (int i = -120; i <= 61 * 120; ++i) {
    const double t = i / 120.0;
    reference.push_back({FromSeconds(100.0 + t), body(t)});
  }
  return reference;
}

// Estimate at 30 Hz over a minute, in its own world frame.
Trajectory Estimate(const Errors& errors, unsigned seed,
                    const std::function<Pose(double)>& body = BodyAt) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal(0.0, errors.noise);
  const Pose T_own_reference = Pose::FromTangent({3.0, -2.0, 1.0}, {0.4, -0.3, 1.0});
  Trajectory estimate;
  for (int i = 0; i < 30 * 60; ++i) {
    const double t = i / 30.0;
    // The reference point is offset from the estimated one by the lever arm.
    const Pose T = body(t);
    const Eigen::Quaterniond q = T.q() * so3::Exp(errors.hand_eye).conjugate();
    const Eigen::Vector3d noise(normal(rng), normal(rng), normal(rng));
    const Pose seen(q, (T.p() - q * errors.lever_arm) / errors.scale + noise);
    estimate.push_back({FromSeconds(100.0 + t + errors.late), T_own_reference * seen});
  }
  return estimate;
}

ErrorExplanation Explain(const Errors& errors, unsigned seed = 1) {
  const Trajectory reference = Reference();
  return ExplainError(reference, AbsolutePoseError(reference, Estimate(errors, seed)));
}

// Residual of the white noise after fitting the six parameters of the rigid motion and the causes,
// which account for 0.1 % of 5400 rows.
const double kLeft = kNoise * std::sqrt(3.0);

TEST(ExplainError, NoiseAloneHasNoCause) {
  const ErrorExplanation explanation = Explain({});
  EXPECT_NEAR(explanation.rmse, kLeft, 0.03 * kLeft);
  ASSERT_TRUE(explanation.all);
  EXPECT_LT(std::abs(explanation.all->time_shift), 4.0 * explanation.all->time_shift_sigma);
  EXPECT_LT(std::abs(explanation.all->scale - 1.0), 4.0 * explanation.all->scale_sigma);
  EXPECT_GT(explanation.all->rmse, 0.99 * explanation.rmse);
  // The mean of 31 images has 1/31 of the noise variance.
  EXPECT_NEAR(explanation.slow, kLeft / std::sqrt(31.0), 0.1 * kLeft / std::sqrt(31.0));
  EXPECT_NEAR(explanation.fast, kLeft * std::sqrt(30.0 / 31.0), 0.03 * kLeft);
}

TEST(ExplainError, FindsALateClock) {
  const ErrorExplanation explanation = Explain({.late = 0.015});
  ASSERT_TRUE(explanation.time_shift);
  EXPECT_NEAR(explanation.time_shift->time_shift, -0.015, 1e-4);
  EXPECT_NEAR(explanation.time_shift->rmse, kLeft, 0.03 * kLeft);
  EXPECT_GT(explanation.rmse, 8e-3);
  ASSERT_TRUE(explanation.scale);
  EXPECT_GT(explanation.scale->rmse, 0.9 * explanation.rmse) << "a scale is no cure";
  EXPECT_EQ(explanation.scale->time_shift, 0.0);
}

TEST(ExplainError, FindsAScale) {
  const ErrorExplanation explanation = Explain({.scale = 1.01});
  ASSERT_TRUE(explanation.scale);
  EXPECT_NEAR(explanation.scale->scale, 1.01, 4.0 * explanation.scale->scale_sigma);
  EXPECT_LT(explanation.scale->scale_sigma, 1e-4);
  EXPECT_NEAR(explanation.scale->rmse, kLeft, 0.03 * kLeft);
  EXPECT_GT(explanation.rmse, 5e-3);
}

TEST(ExplainError, FindsALeverArm) {
  const Eigen::Vector3d lever_arm(0.03, -0.02, 0.05);
  const ErrorExplanation explanation = Explain({.lever_arm = lever_arm});
  ASSERT_TRUE(explanation.lever_arm);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(explanation.lever_arm->lever_arm(i), lever_arm(i),
                4.0 * explanation.lever_arm->lever_arm_sigma(i));
    EXPECT_LT(explanation.lever_arm->lever_arm_sigma(i), 3e-4);
  }
  EXPECT_NEAR(explanation.lever_arm->rmse, kLeft, 0.03 * kLeft);
  EXPECT_GT(explanation.rmse, 0.01);
}

TEST(ExplainError, FindsARotationBetweenTheBodies) {
  const Eigen::Vector3d turn(0.02, -0.03, 0.01);
  const ErrorExplanation explanation = Explain({.hand_eye = turn});
  // The tolerance is the error of aligning positions with a noise of one millimetre.
  EXPECT_LT((explanation.hand_eye - turn).norm(), 1e-3);
  EXPECT_NEAR(explanation.angle_rmse, turn.norm(), 1e-3);
  EXPECT_LT(explanation.angle_rmse_without, 1e-3);
}

TEST(ExplainError, SeparatesCombinedCauses) {
  const Errors errors{.late = -0.012, .scale = 0.995, .lever_arm = {0.01, 0.02, -0.01}};
  const ErrorExplanation explanation = Explain(errors);
  ASSERT_TRUE(explanation.all);
  const ErrorCause& all = *explanation.all;
  EXPECT_NEAR(all.time_shift, 0.012, 1e-4);
  EXPECT_NEAR(all.scale, 0.995, 2e-4);
  EXPECT_LT((all.lever_arm - errors.lever_arm).norm(), 5e-4);
  EXPECT_NEAR(all.rmse, kLeft, 0.03 * kLeft);
  ASSERT_TRUE(explanation.time_shift_and_scale);
  EXPECT_GT(explanation.time_shift_and_scale->rmse, 3.0 * kLeft) << "the lever arm is left";
  double squares = 0.0;
  int count = 0;
  for (const double left : explanation.left) {
    if (std::isnan(left)) continue;
    squares += left * left;
    ++count;
  }
  EXPECT_EQ(explanation.left.size(), 1800U);
  EXPECT_NEAR(std::sqrt(squares / count), all.rmse, 1e-12);
}

// Jackknife: over 200 seeds the squared error matches the stated variance, and nearly all errors
// lie within three sigmas.
TEST(ExplainError, StandardDeviationsAreRightOverTwoHundredSeeds) {
  constexpr int kSeeds = 200;
  double shift = 0.0, scale = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const ErrorExplanation explanation = Explain({.late = 0.005, .scale = 1.002}, seed);
    const ErrorCause& both = *explanation.time_shift_and_scale;
    shift += std::pow((both.time_shift + 0.005) / both.time_shift_sigma, 2) / kSeeds;
    scale += std::pow((both.scale - 1.002) / both.scale_sigma, 2) / kSeeds;
  }
  // With 20 pieces the t-distribution has 19 degrees of freedom and a variance of 19 / 17. The
  // tolerance is four sigmas of the mean of 200 squares, sqrt(2 / 200) each.
  EXPECT_NEAR(shift, 19.0 / 17.0, 0.45);
  EXPECT_NEAR(scale, 19.0 / 17.0, 0.45);
}

TEST(ExplainError, GivesNoLeverArmWithoutRotations) {
  const auto body = [](double t) { return Pose(Eigen::Quaterniond::Identity(), BodyAt(t).p()); };
  const Trajectory reference = Reference(body);
  const ErrorExplanation explanation =
      ExplainError(reference, AbsolutePoseError(reference, Estimate({}, 1, body)));
  EXPECT_FALSE(explanation.lever_arm);
  EXPECT_FALSE(explanation.all);
  ASSERT_TRUE(explanation.time_shift_and_scale);
}

TEST(ExplainError, PassesOverHolesOfTheReference) {
  Trajectory reference = Reference();
  std::erase_if(reference, [](const StampedPose& pose) {
    const double t = ToSeconds(pose.stamp) - 100.0;
    return t > 20.0 && t < 25.0;
  });
  const ErrorExplanation explanation =
      ExplainError(reference, AbsolutePoseError(reference, Estimate({.late = 0.01}, 1)));
  ASSERT_TRUE(explanation.time_shift);
  EXPECT_NEAR(explanation.time_shift->time_shift, -0.01, 2e-4);
}

TEST(ExplainError, RefusesInvalidArguments) {
  const Trajectory reference = Reference();
  const Trajectory estimate = Estimate({}, 1);
  const TrajectoryError error = AbsolutePoseError(reference, estimate);
  EXPECT_THROW(ExplainError(reference, error, {.slow_seconds = 0.0}), InvalidArgument);
  EXPECT_THROW(ExplainError(reference, error, {.max_time_shift = -1.0}), InvalidArgument);
  EXPECT_THROW(ExplainError(reference, error, {.pieces = 3}), InvalidArgument);
  const TrajectoryError scaled = AbsolutePoseError(reference, Estimate({.scale = 1.1}, 1),
                                                   {.alignment = TrajectoryAlignment::kSim3});
  EXPECT_THROW(ExplainError(reference, scaled), InvalidArgument);
  const Trajectory few(estimate.begin(), estimate.begin() + 60);
  EXPECT_THROW(ExplainError(reference, AbsolutePoseError(reference, few)), InvalidArgument);
}

}  // namespace
}  // namespace highwall::error_explanation_test
