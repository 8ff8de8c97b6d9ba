#include <gtest/gtest.h>

#include <highwall/core/camera.h>

#include "tracking/constant_velocity.h"

namespace highwall::constant_velocity_test {
namespace {

const Pose kStep =
    Pose::FromTangent({0.19, -0.02, 0.05}, {0.05, 0.28, -0.03});  // 19 cm, 16 degrees

void ExpectNear(const Pose& a, const Pose& b) {
  EXPECT_LT((a.p() - b.p()).norm(), 1e-12);
  EXPECT_LT((a.Inverse() * b).Angle(), 1e-12);
}

TEST(ConstantVelocity, StandsStillAtFirst) {
  ExpectNear(ConstantVelocity().Predict(0.1), Pose());
}

TEST(ConstantVelocity, RepeatsItsStepInTheSameTime) {
  ConstantVelocity velocity;
  velocity.Measure(kStep, 0.1);
  ExpectNear(velocity.Predict(0.1), kStep);
}

TEST(ConstantVelocity, AMissingImageIsTwoSteps) {
  ConstantVelocity velocity;
  velocity.Measure(kStep, 0.1);
  ExpectNear(velocity.Predict(0.2), kStep * kStep);
  // This is the error in the image if the interval between images were ignored: 16 degrees more.
  const PinholeCamera camera;
  const Eigen::Vector3d p_C(0.2, 0.1, 2.0);
  const auto seen = [&](const Pose& T) { return camera.Project(T.Inverse() * p_C); };
  EXPECT_LT((seen(velocity.Predict(0.2)) - seen(kStep * kStep)).norm(), 1e-9);  // [px]
  EXPECT_GT((seen(kStep) - seen(kStep * kStep)).norm(), 90.0);
}

TEST(ConstantVelocity, BetweenTwoStepsMotionIsBetweenTheirs) {
  // The speed increases evenly: 1 m/s in the middle of the first 0.1 s, 2.5 in that of the next
  // 0.2.
  ConstantVelocity before, after;
  before.Measure(Pose::FromTangent({0, 0, 0.1}, {0, 0, 0.01}), 0.1);
  after.Measure(Pose::FromTangent({0, 0, 0.5}, {0, 0, 0.05}), 0.2);
  const Twist between = after.AtBeginning(before);
  EXPECT_NEAR(between.v.z(), 1.5, 1e-12);
  EXPECT_NEAR(between.omega.z(), 0.15, 1e-12);
  // Without a step before, only the step after is known.
  EXPECT_EQ(after.AtBeginning(ConstantVelocity()).v, after.twist().v);
}

TEST(ConstantVelocity, HalfAStepTwiceIsAStep) {
  ConstantVelocity velocity;
  velocity.Measure(kStep, 0.1);
  const Pose half = velocity.Predict(0.05);
  ExpectNear(half * half, kStep);
}

TEST(ConstantVelocity, ARepeatedStampGivesNoVelocity) {
  ConstantVelocity velocity;
  velocity.Measure(kStep, 0.1);
  for (const double dt : {0.001, 0.0, -0.1})
    velocity.Measure(Pose::FromTangent({1, 0, 0}, {0, 0, 0}), dt);
  ExpectNear(velocity.Predict(0.1), kStep);
  ExpectNear(velocity.Predict(0.0), Pose());
  ExpectNear(velocity.Predict(-0.1), Pose());
}

TEST(ConstantVelocity, StopsExtrapolatingAfterAWhile) {
  ConstantVelocity velocity;
  velocity.Measure(kStep, 0.1);
  ExpectNear(velocity.Predict(20.0), velocity.Predict(0.5));
  // A low image rate belongs to a slow camera.
  velocity.Measure(kStep, 2.0);
  ExpectNear(velocity.Predict(2.0), kStep);
  ExpectNear(velocity.Predict(20.0), kStep);
}

TEST(ConstantVelocity, ForgetsWhenReset) {
  ConstantVelocity velocity;
  velocity.Measure(kStep, 0.1);
  velocity.Reset();
  ExpectNear(velocity.Predict(0.1), Pose());
}

}  // namespace
}  // namespace highwall::constant_velocity_test
