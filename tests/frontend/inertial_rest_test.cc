#include <cstddef>

#include <gtest/gtest.h>

#include <highwall/frontend/inertial/inertial_odometry.h>

#include "inertial_drive.h"

// Conditions under which a body is stationary, and under which it is not.
namespace highwall::inertial_rest_test {
namespace {

using testing::AngleBetween;
using testing::Drive;
using testing::kDegree;
using testing::kFirst;
using testing::kStep;
using testing::kTilted;

TEST(InertialRest, InitializesAtRestAndDetectsThatItIsStationary) {
  Drive drive({.motion = 0.0, .T_WN = kTilted});
  drive.Until(4.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
  EXPECT_TRUE(drive.reports.back().stationary);
  EXPECT_LT(drive.odometry.estimate()->state.v_WB.norm(), 6e-3);
  EXPECT_LT(AngleBetween(*drive.odometry.gravity_W(), drive.T_map.q() * drive.scene.gravity_W()),
            0.3 * kDegree);
  Drive moving;
  moving.Until(4.0);
  ASSERT_EQ(moving.odometry.status(), InertialStatus::kRunning);
  for (const InertialReport& report : moving.reports) EXPECT_FALSE(report.stationary);
}

TEST(InertialRest, ASlowMotionIsNotStationaryAndItsVelocityIsRight) {
  for (const double creep : {0.005, 0.01, 0.02, 0.028}) {
    Drive drive({.motion = 0.0, .creep = creep, .T_WN = kTilted});
    drive.Until(8.0);
    ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
    double along = 0.0;  // [m/s] mean over 60 images
    constexpr int kImages = 60;
    for (int i = 1; i <= kImages; ++i) {
      drive.Until(8.0 + kStep * i);
      const Eigen::Vector3d x = drive.T_map.q() * Eigen::Vector3d::UnitX();
      along += drive.odometry.estimate()->state.v_WB.dot(x) / kImages;
    }
    for (const InertialReport& report : drive.reports) EXPECT_FALSE(report.stationary) << creep;
    // An image is off by 1 mm, at both ends of 6 s; three sigmas.
    EXPECT_NEAR(along, creep, 7e-4) << creep;
  }
}

TEST(InertialRest, StaysStationaryWithoutImagesOnceItWasAtRest) {
  Drive drive({.motion = 0.0, .T_WN = kTilted});
  drive.Until(8.0, [](double t) { return t < 5.0; });
  std::size_t at_rest = 0, dark = 0;
  for (std::size_t i = 0; i < drive.reports.size(); ++i) {
    if (kFirst + kStep * static_cast<double>(i) < 5.0) continue;
    ++dark;
    if (drive.reports[i].stationary) ++at_rest;
  }
  EXPECT_GT(dark, 25u);
  EXPECT_EQ(at_rest, dark);
  EXPECT_LT(drive.PositionError(), 0.01);
}

}  // namespace
}  // namespace highwall::inertial_rest_test
