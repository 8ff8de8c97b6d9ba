#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <highwall/core/so3.h>

#include "inertial_drive.h"

namespace highwall::inertial_extrinsics_test {
namespace {

using testing::Drive;
using testing::InertialScene;
using testing::kBias;
using testing::kDegree;
using testing::kTilted;

const Pose kOff(so3::Exp(kDegree* Eigen::Vector3d(1, 1, 1).normalized()),
                0.01 * Eigen::Vector3d(1, -1, 1).normalized());

TEST(InertialExtrinsics, AreFoundWhereTheyAreACentimetreAndADegreeOff) {
  Drive drive({.bias = kBias, .T_WN = kTilted}, {.estimate_extrinsics = true}, kOff);
  drive.Until(20.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
  ASSERT_TRUE(drive.reports.back().extrinsics);
  const ExtrinsicsEstimate& found = *drive.reports.back().extrinsics;
  const Pose error = InertialScene::T_BC().Inverse() * found.T_BC;
  // The images are a tenth of a second apart, each with a millimetre of noise.
  EXPECT_LT(error.p().norm(), 3e-3);
  EXPECT_LT(error.Angle(), 0.1 * kDegree);
  const Eigen::Vector3d p_B = InertialScene::T_BC().q() * error.p();
  const Eigen::Vector3d theta = so3::Log(error.q());
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(p_B[i]), 4.0 * found.lever_arm_sigma[i]) << i;
    EXPECT_LT(std::abs(theta[i]), 4.0 * found.rotation_sigma[i]) << i;
    EXPECT_TRUE(found.lever_arm_seen[static_cast<std::size_t>(i)]) << i;
    EXPECT_TRUE(found.rotation_seen[static_cast<std::size_t>(i)]) << i;
  }
  EXPECT_EQ(drive.odometry.T_BC().Matrix(), found.T_BC.Matrix());
  EXPECT_LT(drive.PositionError(), 3e-3);
}

TEST(InertialExtrinsics, StandWhereTheyAreNotEstimated) {
  Drive drive({.bias = kBias, .T_WN = kTilted}, {}, kOff);
  drive.Until(5.0);
  EXPECT_FALSE(drive.reports.back().extrinsics);
  EXPECT_EQ(drive.odometry.T_BC().Matrix(), (InertialScene::T_BC() * kOff).Matrix());
}

TEST(InertialExtrinsics, AreNotSeenAtRest) {
  Drive drive({.motion = 0.0}, {.estimate_extrinsics = true});
  drive.Until(6.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
  const ExtrinsicsEstimate& found = *drive.reports.back().extrinsics;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(found.lever_arm_seen[i]) << i;
    EXPECT_FALSE(found.rotation_seen[i]) << i;
  }
}

TEST(InertialExtrinsics, AreNotSeenAtRestBetweenGapsInTheReadings) {
  Drive drive({.motion = 0.0}, {.estimate_extrinsics = true}, kOff);
  drive.change = [](const ImuSample& reading) {
    const double t = ToSeconds(reading.stamp);
    return t < 3.0 || std::fmod(t, 1.0) > 0.25;
  };
  drive.Until(7.9);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
  EXPECT_GE(std::ranges::count_if(drive.reports, &InertialReport::restarted), 4);
  const ExtrinsicsEstimate& found = *drive.reports.back().extrinsics;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_FALSE(found.lever_arm_seen[i]) << i;
    EXPECT_FALSE(found.rotation_seen[i]) << i;
  }
}

}  // namespace
}  // namespace highwall::inertial_extrinsics_test
