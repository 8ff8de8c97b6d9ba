#include <highwall/frontend/inertial/options.h>

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "inertial/inertial_odometry.h"

namespace highwall {
namespace {

TEST(InertialOptions, ErrorsNameTheField) {
  const auto expect_error = [](const InertialOptions& options, const std::string& field) {
    try {
      const InertialOdometry odometry({}, options);
      FAIL() << field;
    } catch (const InvalidArgument& e) {
      EXPECT_NE(std::string(e.what()).find(field), std::string::npos) << e.what();
    }
  };
  EXPECT_NO_THROW(InertialOptions().Validate());
  expect_error({.weighting = {.fixed_weight = 0.0}}, "fixed_weight");
  expect_error({.initializer = {.interval = 0.0}}, "interval");
  expect_error({.window_states = 1}, "window_states");
  expect_error({.max_attempts = 0}, "max_attempts");
  expect_error({.visual_noise = {.scale = 0.0}}, "scale");
  expect_error({.max_dead_reckoning = 0.0}, "max_dead_reckoning");
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
}  // namespace highwall
