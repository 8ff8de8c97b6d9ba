// Readings of an IMU that contradict the images, or seem to.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/frontend/inertial/inertial_odometry.h>

#include "inertial_drive.h"

namespace highwall::inertial_contradiction_test {
namespace {

using testing::AngleBetween;
using testing::Drive;
using testing::InertialScene;
using testing::kBias;
using testing::kDegree;
using testing::kFirst;
using testing::kStep;

TEST(InertialContradiction, GivesUpAnImuThatContradictsTheImages) {
  for (const bool in_g : {false, true}) {
    Drive drive({}, {.max_attempts = 3});
    drive.change = [&](ImuSample& reading) {
      reading.accelerometer *= in_g ? 1.0 / 9.80665 : -1.0;
      return true;
    };
    drive.Until(5.0);
    EXPECT_EQ(drive.odometry.status(), InertialStatus::kGivenUp) << in_g;
    EXPECT_FALSE(drive.odometry.T_WC());
    const InertialReport& report = drive.reports.back();
    EXPECT_EQ(report.status, InertialStatus::kGivenUp);
    EXPECT_FALSE(report.reason.empty());
    if (!in_g) continue;
    EXPECT_NE(report.reason.find("m/s^2"), std::string::npos) << report.reason;
  }
}

// The sign is not tested here: the judgement of the readings is earlier.
TEST(InertialContradiction, AnImuThatIsContradictedFromTheBeginningIsAFindingBeforeItIsGivenUp) {
  for (const double factor : {1.2, 1.0}) {
    Drive drive;
    drive.change = [factor](ImuSample& reading) {
      reading.accelerometer *= factor;
      return true;
    };
    drive.Until(5.0);
    EXPECT_NE(drive.odometry.status(), InertialStatus::kGivenUp) << factor;
    std::vector<SensorFault> faults;
    for (const InertialReport& report : drive.reports) {
      if (report.finding) faults.push_back(report.finding->fault);
    }
    const std::vector<SensorFault> one{SensorFault::kImuScale};
    EXPECT_EQ(faults, factor == 1.0 ? std::vector<SensorFault>() : one) << factor;
  }
}

// Image poses that accelerate upwards by 0.7 m/s^2 yield a gravity of 9.1 m/s^2, although the mean
// reading is some 9.9.
TEST(InertialContradiction, PoorPosesDoNotEndTheUseOfReadingsThatAreRight) {
  Drive drive({}, {.max_attempts = 3});
  drive.drift = [](double t) { return Eigen::Vector3d(0.0, 0.0, t < 10.0 ? 0.35 * t * t : 0.0); };
  drive.Until(9.9);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kInitializing);
  const std::string& reason = drive.reports.back().reason;
  EXPECT_NE(reason.find("the readings alone 9.9"), std::string::npos) << reason;
  EXPECT_NE(reason.find("tried again"), std::string::npos) << reason;
  drive.Until(25.0);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
  EXPECT_LT(drive.PositionError(), 5e-3);
}

TEST(InertialContradiction, AnImuThatWasGivenUpIsUsedOnceItFits) {
  Drive drive({}, {.max_attempts = 3});
  drive.change = [](ImuSample& reading) {
    if (ToSeconds(reading.stamp) < 6.0) reading.accelerometer *= -1.0;
    return true;
  };
  drive.Until(6.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kGivenUp);
  EXPECT_FALSE(drive.reports.back().reason.empty());
  drive.Until(25.0);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
  EXPECT_LT(drive.PositionError(), 5e-3);
}

TEST(InertialContradiction, ACameraMountedUpsideDownDoesNotContradictTheImu) {
  InertialScene scene({.bias = kBias});
  const Pose T_turn = Pose::FromTangent({0, 0, 0}, {0, 0, M_PI});  // about the optical axis
  ImuCalibration calibration = scene.calibration();
  calibration.T_BC = calibration.T_BC * T_turn;
  InertialOdometry odometry(calibration);
  Pose T_map;
  double read = 0.0;
  for (int i = 0; i <= 40; ++i) {
    const double t = kFirst + kStep * i;
    for (const ImuSample& reading : scene.Readings(read, t + 0.1)) odometry.AddSample(reading);
    read = t + 0.1 + 1.0 / 200.0;
    InertialOdometry::Observation observation;
    observation.image = FromSeconds(t);
    observation.visual = scene.See(t);
    observation.visual->T_WC = T_map * observation.visual->T_WC * T_turn;
    const InertialReport report = odometry.Update(observation);
    if (report.T_gravity) T_map = *report.T_gravity * T_map;
    ASSERT_NE(report.status, InertialStatus::kGivenUp) << report.reason;
    EXPECT_FALSE(report.finding);
  }
  ASSERT_EQ(odometry.status(), InertialStatus::kRunning);
  EXPECT_LT(AngleBetween(*odometry.gravity_W(), T_map.q() * scene.gravity_W()), 0.3 * kDegree);
}

}  // namespace
}  // namespace highwall::inertial_contradiction_test
