// Clocks of the IMU and the images that are apart by another time than stated.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/frontend/inertial/inertial_odometry.h>

#include "inertial_drive.h"

namespace highwall::inertial_clock_test {
namespace {

using testing::Drive;
using testing::kBias;

// It is estimated, so that the IMU remains in use.
TEST(InertialOdometry, ReportsClocksThatAreFartherApartThanStatedOnce) {
  for (const double offset : {-0.04, 0.0, 0.02, 0.04}) {
    Drive drive({.motion = 0.5, .bias = kBias, .time_offset = offset});
    drive.Until(8.0);
    ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
    std::vector<SensorFinding> findings;
    for (const InertialReport& report : drive.reports) {
      if (report.finding) findings.push_back(*report.finding);
    }
    ASSERT_EQ(findings.size(), std::abs(offset) > 0.03 ? 1u : 0u) << offset;
    if (findings.empty()) continue;
    EXPECT_EQ(findings.front().fault, SensorFault::kImuClock);
    EXPECT_NE(findings.front().text.find(offset > 0.0 ? "ms ahead of" : "ms behind"),
              std::string::npos)
        << findings.front().text;
  }
}

}  // namespace
}  // namespace highwall::inertial_clock_test
