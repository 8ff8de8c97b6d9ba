#include "inertial/imu_monitor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include <highwall/core/so3.h>

#include "inertial_drive.h"

namespace highwall::imu_monitor_test {
namespace {

using testing::Drive;
using testing::Shock;

TEST(ImuMonitor, ARunningImuIsGivenUpWhenItsGyroscopeTurnsRound) {
  Drive drive;
  drive.change = [](ImuSample& reading) {
    if (ToSeconds(reading.stamp) > 5.0) reading.gyroscope *= -1.0;
    return true;
  };
  drive.Until(5.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  drive.Until(15.0);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kGivenUp);
  EXPECT_FALSE(drive.odometry.T_WC());
  int abandoned = 0, findings = 0;
  for (const InertialReport& report : drive.reports) {
    abandoned += report.abandoned ? 1 : 0;
    findings += report.finding ? 1 : 0;
    if (report.finding) {
      EXPECT_FALSE(report.finding->text.empty());
    }
  }
  EXPECT_GE(abandoned, 1);
  EXPECT_GE(findings, 1);
}

// [s] when it is given up first; infinite if it never is.
double GivenUpAt(const Drive& drive) {
  const auto first = std::ranges::find_if(drive.reports, &InertialReport::abandoned);
  if (first == drive.reports.end()) return std::numeric_limits<double>::infinity();
  return testing::kFirst + testing::kStep * static_cast<double>(first - drive.reports.begin());
}

// Poses of images have errors that last for seconds, and less often for longer than a window.
TEST(ImuMonitor, AfterLongUseAContradictionMustLastForAWholeWindow) {
  Drive drive;
  drive.change = [](ImuSample& reading) {
    if (ToSeconds(reading.stamp) > 30.0) reading.gyroscope *= -1.0;
    return true;
  };
  drive.Until(55.0);
  EXPECT_GT(GivenUpAt(drive), 30.0 + ImuMonitor::kMonitored);
  EXPECT_LT(GivenUpAt(drive), 50.0);
}

TEST(ImuMonitor, AfterLongUseAShortContradictionEndsNothing) {
  Drive drive;
  drive.change = [](ImuSample& reading) {
    const double t = ToSeconds(reading.stamp);
    if (t > 30.0 && t < 32.0) reading.gyroscope *= -1.0;
    return true;
  };
  drive.Until(50.0);
  EXPECT_GT(GivenUpAt(drive), 50.0);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kRunning);
}

// The images contradict the readings of a shock: without these, nothing speaks against the IMU.
TEST(ImuMonitor, AShockSoonAfterTheStartEndsNothing) {
  for (const double shock :
       {2.52, 2.57, 3.04}) {  // [s] within an interval of images, over an image
    Drive drive;
    drive.change = Shock(shock, shock + 0.06);
    drive.Until(2.5);
    ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
    drive.Until(12.0);
    EXPECT_GT(GivenUpAt(drive), 12.0) << shock;
    EXPECT_FALSE(std::ranges::any_of(drive.reports, [](const InertialReport& report) {
      return report.finding.has_value();
    })) << shock;
  }
}

TEST(ImuMonitor, AnImuThatIsContradictedAllTheTimeIsGivenUp) {
  Drive drive;
  drive.change = [](ImuSample& reading) {
    const double t = ToSeconds(reading.stamp);
    if (t > 2.5 && std::fmod(t, 0.3) < 0.1) reading.gyroscope += Eigen::Vector3d(1.0, 2.0, -1.5);
    return true;
  };
  drive.Until(12.0);
  EXPECT_LT(GivenUpAt(drive), 12.0);
}

// What turns the wrong way is contradicted only while the camera turns.
TEST(ImuMonitor, AGyroscopeThatIsWrongForASecondAndAHalfIsNoShock) {
  Drive drive;
  drive.change = [](ImuSample& reading) {
    const double t = ToSeconds(reading.stamp);
    if (t > 6.0 && t < 7.5) reading.gyroscope *= -1.0;
    return true;
  };
  drive.Until(9.0);
  EXPECT_LT(GivenUpAt(drive), 9.0);
}

// Judges an IMU whose camera turns for 0.3 s about each axis in eight seconds, which are left out,
// and rests otherwise. gyroscope: the reading at an angular velocity of the body.
ImuJudgement JudgementOfTurns(
    const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& gyroscope) {
  constexpr double kDuration = 0.3;                // [s]
  constexpr std::array kBegins = {2.0, 4.0, 6.0};  // [s]
  const auto share = [&](int axis, double t) {
    return std::clamp((t - kBegins[static_cast<std::size_t>(axis)]) / kDuration, 0.0, 1.0);
  };
  const auto rotation = [&](double t) {
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    for (int axis = 0; axis < 3; ++axis) {
      const double angle = 0.5 * (1.0 - std::cos(M_PI * share(axis, t)));
      q = q * so3::Exp(angle * Eigen::Vector3d::Unit(axis));
    }
    return q;
  };
  ImuMonitor monitor(0.1);
  ImuBuffer readings;
  for (int i = 0; i <= 1600; ++i) {
    const double t = i / 200.0;
    Eigen::Vector3d rate;
    for (int axis = 0; axis < 3; ++axis) {
      rate(axis) = 0.5 * M_PI / kDuration * std::sin(M_PI * share(axis, t));
    }
    readings.Add({.stamp = FromSeconds(t),
                  .gyroscope = gyroscope(rate),
                  .accelerometer = rotation(t).conjugate() * -kGravity});
  }
  constexpr int kPoses = 235;
  for (int i = 0; i < kPoses; ++i) {
    monitor.Add(FromSeconds(i / 30.0), Pose(rotation(i / 30.0), Eigen::Vector3d::Zero()));
  }
  for (const double begin : kBegins) {
    monitor.LeaveOut(FromSeconds(begin), FromSeconds(begin + kDuration));
  }
  return monitor.Check(FromSeconds(kPoses / 30.0), readings, ImuCalibration(), false).value();
}

TEST(ImuMonitor, ContradictionsThatOneFaultExplainsAreNoShocks) {
  const ImuJudgement turned =
      JudgementOfTurns([](const auto& rate) -> Eigen::Vector3d { return -rate; });
  EXPECT_EQ(turned.agreement, ImuAgreement::kContradicted);
  ASSERT_TRUE(turned.finding);
  EXPECT_EQ(turned.finding->fault, SensorFault::kImuSign);
  const ImuJudgement shaken = JudgementOfTurns([](const auto& rate) -> Eigen::Vector3d {
    return {std::sin(40.0 * rate.sum()), std::cos(55.0 * rate.sum()) - 1.0,
            std::sin(70.0 * rate.sum())};
  });
  EXPECT_EQ(shaken.agreement, ImuAgreement::kUndecided);
}

TEST(ImuMonitor, ARightImuIsNeverGivenUp) {
  Drive drive;
  drive.Until(15.0);
  for (const InertialReport& report : drive.reports) {
    EXPECT_FALSE(report.abandoned);
    EXPECT_FALSE(report.finding);
  }
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kRunning);
}

TEST(ImuMonitor, AWrongMountKeepsTheImuFromStartingAndIsNamed) {
  const Pose quarter = Pose::FromTangent({0, 0, 0}, {0.0, 0.5 * M_PI, 0.0});
  Drive drive({}, {}, quarter);
  drive.Until(8.0);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kGivenUp);
  const bool named = std::ranges::any_of(drive.reports, [](const InertialReport& report) {
    return report.finding && report.finding->fault == SensorFault::kImuMount;
  });
  EXPECT_TRUE(named);
}

}  // namespace
}  // namespace highwall::imu_monitor_test
