#include "inertial/clock_check.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace highwall::clock_check_test {
namespace {

constexpr double kInterval = 1.0 / 30.0;  // [s] between images

// Estimates an offset [s] for 30 s. Its stated standard deviation falls from 3 to 0.3 ms within
// some seconds; its errors are half as large again, and last for half a second.
bool IsReported(double offset, std::mt19937& rng) {
  std::normal_distribution<double> normal;
  const double kept = std::exp(-kInterval / 0.5);
  double error = normal(rng);
  ClockCheck check;
  for (int i = 0; i < 900; ++i) {
    const double sigma = 0.0003 + 0.0027 * std::exp(-i * kInterval / 3.0);
    error = kept * error + std::sqrt(1.0 - kept * kept) * normal(rng);
    if (check.Update(FromSeconds(i * kInterval), offset + 1.5 * sigma * error, sigma)) return true;
  }
  return false;
}

// The rate is that of a recording. At one in a thousand, six and more alarms in 2000 draws have a
// probability of 1.7 %.
TEST(ClockCheck, RaisesFalseAlarmsAtMostOnceInAThousandDrawsOfToleratedOffsets) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> within(-0.03, 0.03);
  int alarms = 0;
  for (int draw = 0; draw < 2000; ++draw) {
    const double offset = within(rng);
    alarms += IsReported(offset, rng) ? 1 : 0;
  }
  EXPECT_LE(alarms, 5);
}

TEST(ClockCheck, ReportsClocksThatAreFiftyMillisecondsApart) {
  std::mt19937 rng(4);
  for (int draw = 0; draw < 100; ++draw) {
    EXPECT_TRUE(IsReported(draw % 2 == 0 ? 0.05 : -0.05, rng)) << draw;
  }
}

TEST(ClockCheck, AnEstimateThatIsNotFiniteIsNoFinding) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ClockCheck check;
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(check.Update(FromSeconds(0.1 * i), i % 2 == 0 ? nan : 0.1, nan));
  }
}

TEST(ClockCheck, NeedsASecondWithoutInterruptionAndReportsOnce) {
  ClockCheck check;
  const auto update = [&](double seconds) {
    return check.Update(FromSeconds(seconds), 0.1, 0.001);
  };
  EXPECT_FALSE(update(0.0));
  EXPECT_FALSE(update(0.9));
  check.Interrupt();
  EXPECT_FALSE(update(1.1));
  EXPECT_FALSE(update(2.0));
  EXPECT_TRUE(update(2.2));
  EXPECT_FALSE(update(2.3));
}

}  // namespace
}  // namespace highwall::clock_check_test
