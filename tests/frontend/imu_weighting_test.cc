
#include <gtest/gtest.h>

#include "inertial/imu_weighting.h"

namespace highwall::imu_weighting_test {
namespace {

const ImuWeightInput kRapid{.motion = {.angular_rate = 5.0}, .squared_innovation = 6.0, .dof = 6};
const ImuWeightInput kWild{.motion = {}, .squared_innovation = 600.0, .dof = 6};

TEST(ImuWeighting, PaperFollowsTheMotionAndNoInnovation) {
  ImuWeight weight({.policy = ImuWeighting::kPaper});
  PaperImuWeight paper;
  for (int i = 0; i < 20; ++i) {
    const ImuWeightInput& input = i < 10 ? kWild : kRapid;
    EXPECT_EQ(weight.Update(input), paper.Update(input.motion)) << i;
    EXPECT_EQ(weight.weight(), paper.weight());
  }
  EXPECT_GE(weight.weight(), 0.7);
}

TEST(ImuWeighting, ConsistentFollowsTheInnovationAndNoMotion) {
  ImuWeight weight({.policy = ImuWeighting::kConsistent});
  EXPECT_EQ(weight.weight(), 1.0);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(weight.Update(kRapid), 1.0) << i;
  ConsistentImuWeight consistent;
  for (int i = 0; i < 20; ++i) consistent.Update(6.0, 6);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(weight.Update(kWild), consistent.Update(600.0, 6)) << i;
  EXPECT_LT(weight.weight(), 0.1);
}

TEST(ImuWeighting, ConsistentKeepsItsWeightWhereThereIsNoInnovation) {
  ImuWeight weight({.policy = ImuWeighting::kConsistent});
  for (int i = 0; i < 20; ++i) weight.Update(kWild);
  const double before = weight.weight();
  ASSERT_LT(before, 1.0);
  EXPECT_EQ(weight.Update({.motion = {.angular_rate = 5.0}}), before);
}

TEST(ImuWeighting, FixedIsFixed) {
  ImuWeight weight({.policy = ImuWeighting::kFixed, .fixed_weight = 2.5});
  EXPECT_EQ(weight.weight(), 2.5);
  EXPECT_EQ(weight.Update(kWild), 2.5);
  EXPECT_EQ(weight.Update(kRapid), 2.5);
}

TEST(ImuWeighting, PoliciesHaveNames) {
  EXPECT_STREQ(ToString(ImuWeighting::kPaper), "paper");
  EXPECT_STREQ(ToString(ImuWeighting::kConsistent), "consistent");
  EXPECT_STREQ(ToString(ImuWeighting::kFixed), "fixed");
}

}  // namespace
}  // namespace highwall::imu_weighting_test
