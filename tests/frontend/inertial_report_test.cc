#include <limits>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/inertial/inertial_odometry.h>

namespace highwall::inertial_report_test {
namespace {

TEST(ImuCalibration, NeedsARateThatIsFinite) {
  ImuCalibration calibration;
  for (const double bad : {0.0, std::numeric_limits<double>::infinity()}) {
    calibration.rate = bad;
    EXPECT_THROW(InertialOdometry{calibration}, InvalidArgument) << bad;
  }
}

TEST(InertialStatus, HasNames) {
  EXPECT_STREQ(ToString(InertialStatus::kDeadReckoning), "dead reckoning");
  EXPECT_STREQ(ToString(InertialStatus::kGivenUp), "given up");
}

}  // namespace
}  // namespace highwall::inertial_report_test
