#include "run/depth_scale_check.h"

#include <random>
#include <string>

#include <gtest/gtest.h>

namespace highwall::apps::depth_scale_check_test {
namespace {

// At a rate of one in a thousand, eight and more alarms in 3000 draws have a probability of 1 %.
TEST(CheckDepthScale, RaisesFalseAlarmsAtMostOnceInAThousandDraws) {
  std::mt19937 rng(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int alarms = 0;
  for (int i = 0; i < 3000; ++i) {
    const double truth = 1.0 + 0.02 * uniform(rng);  // as depth cameras have it
    const double sigma = 0.03 * (1.1 + uniform(rng));
    alarms +=
        CheckDepthScale({.scale = truth + sigma * normal(rng), .sigma = sigma}, 1000.0) ? 1 : 0;
  }
  EXPECT_LE(alarms, 7);
}

TEST(CheckDepthScale, StatesTheFactorAndTrustsLessWhatIsFarOff) {
  const auto some = CheckDepthScale({.scale = 1.08, .sigma = 0.01}, 1000.0);
  ASSERT_TRUE(some);
  EXPECT_EQ(some->fault, SensorFault::kDepthScale);
  EXPECT_EQ(some->trust, Trust::kDoubtful);
  EXPECT_EQ(some->text, "by the IMU, depth reads 7.4 % too short");
  EXPECT_NE(some->remedy.find("depth_factor: 925.9"), std::string::npos) << some->remedy;
  const auto much = CheckDepthScale({.scale = 0.8, .sigma = 0.01}, 5000.0);
  ASSERT_TRUE(much);
  EXPECT_EQ(much->trust, Trust::kNotTrusted);
  EXPECT_NE(much->remedy.find("depth_factor: 6250"), std::string::npos) << much->remedy;
}

TEST(LeavesNoScale, AnImuWhoseClockAloneIsApartHasAScale) {
  EXPECT_FALSE(LeavesNoScale({.fault = SensorFault::kImuClock}));
  EXPECT_FALSE(LeavesNoScale({.fault = SensorFault::kDepthScale}));
  EXPECT_TRUE(LeavesNoScale({.fault = SensorFault::kImuMount}));
  EXPECT_TRUE(LeavesNoScale({.fault = SensorFault::kImuInconsistent}));
}

TEST(CheckDepthScale, NeedsFivePercentAndFiveStandardDeviations) {
  EXPECT_FALSE(CheckDepthScale({.scale = 1.049, .sigma = 0.001}, 1000.0));
  EXPECT_FALSE(CheckDepthScale({.scale = 1.22, .sigma = 0.05}, 1000.0));
  EXPECT_TRUE(CheckDepthScale({.scale = 1.26, .sigma = 0.05}, 1000.0));
}

TEST(IsScaleMeaningful, NeedsAnImuInUseAndASettledClock) {
  InertialReport last;
  last.status = InertialStatus::kRunning;
  last.time_offset_sigma = 1e-3;
  EXPECT_TRUE(IsScaleMeaningful(last));
  last.time_offset_sigma = 5e-3;
  EXPECT_FALSE(IsScaleMeaningful(last));
  last.time_offset_sigma = 1e-3;
  last.status = InertialStatus::kGivenUp;
  EXPECT_FALSE(IsScaleMeaningful(last));
}

}  // namespace
}  // namespace highwall::apps::depth_scale_check_test
