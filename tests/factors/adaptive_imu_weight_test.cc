#include <highwall/factors/adaptive_imu_weight.h>

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

namespace highwall::adaptive_imu_weight_test {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

// Returns the weight after the measures have been constant for a while.
double Settled(const MotionMeasures& measures, PaperImuWeight weight = PaperImuWeight()) {
  for (int i = 0; i < 100; ++i) weight.Update(measures);
  return weight.weight();
}

TEST(MeasureMotion, IsRootMeanSquareAndStandardDeviation) {
  // Rates of 3 and 4 rad/s in addition to a bias: RMS sqrt(12.5). |a| of 8 and 12: standard
  // deviation 2.
  const std::vector<ImuSample> samples = {{0, {3.1, 0, 0}, {0, 0, 8.2}},
                                          {1, {0.1, 4, 0}, {0, 12, 0.2}}};
  const ImuBias bias = (ImuBias() << 0.1, 0, 0, 0, 0, 0.2).finished();
  const MotionMeasures measures = MeasureMotion(samples, bias);
  EXPECT_NEAR(measures.angular_rate, std::sqrt(12.5), 1e-14);
  EXPECT_NEAR(measures.accelerometer_std, 2.0, 1e-14);
  EXPECT_THROW(MeasureMotion({}, bias), InvalidArgument);
}

TEST(PaperImuWeight, LiesFrom30To40PercentAtRestAndInSlowMotion) {
  for (const double rate : {0.0, 0.1, 0.2, 0.35}) {
    const double w = Settled({.angular_rate = rate, .accelerometer_std = 0.2});
    EXPECT_GE(w, 0.3) << rate;
    EXPECT_LE(w, 0.4) << rate;
  }
  EXPECT_EQ(Settled({}), 0.3);
}

TEST(PaperImuWeight, LiesFrom70To80PercentInRapidMotionVibrationAndBlur) {
  const MotionMeasures regimes[] = {
      {.angular_rate = 1.0},       // fast rotation
      {.accelerometer_std = 2.5},  // vibration
      {.sharpness = 0.3},          // blur
      {.tracked_share = 0.2},      // most features lost
      {.angular_rate = 3.0, .accelerometer_std = 5.0, .sharpness = 0.1, .tracked_share = 0.0}};
  for (const MotionMeasures& measures : regimes) {
    // Tested once with a start in the regime, and once coming from rest.
    EXPECT_EQ(PaperImuWeight().Update(measures), 0.8);
    PaperImuWeight from_rest;
    from_rest.Update({});
    const double w = Settled(measures, from_rest);
    EXPECT_GE(w, 0.7);
    EXPECT_LE(w, 0.8);
  }
}

TEST(PaperImuWeight, LiesBetweenInMiddlingMotion) {
  EXPECT_NEAR(Settled({.angular_rate = 0.6}), 0.55, 1e-12);
  const double w = Settled({.accelerometer_std = 1.0});
  EXPECT_GT(w, 0.4);
  EXPECT_LT(w, 0.7);
}

TEST(PaperImuWeight, IsAContinuousIncreasingFunctionOfTheActivity) {
  const PaperImuWeight weight;
  constexpr double kStep = 1e-4;
  double previous = weight.WeightOf(0.0);
  EXPECT_EQ(previous, 0.3);
  for (double a = kStep; a < 1.0; a += kStep) {
    const double w = weight.WeightOf(a);
    EXPECT_GE(w, previous);
    EXPECT_LT(w - previous, 1.0 * kStep) << a;  // steepest in the middle: 0.3 * 1.5 / 0.5
    previous = w;
  }
  EXPECT_EQ(weight.WeightOf(1.0), 0.8);
  EXPECT_EQ(weight.WeightOf(7.0), 0.8);
}

TEST(PaperImuWeight, NeverJumpsBetweenIntervals) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  const PaperImuWeightOptions options;
  PaperImuWeight weight(options);
  double previous = weight.Update({});
  for (int i = 0; i < 2000; ++i) {
    const double w = weight.Update({.angular_rate = 2.0 * u(rng),
                                    .accelerometer_std = 3.0 * u(rng),
                                    .sharpness = u(rng),
                                    .tracked_share = u(rng)});
    EXPECT_LE(std::abs(w - previous), options.max_change + 1e-15);
    EXPECT_GE(w, 0.3);
    EXPECT_LE(w, 0.8);
    previous = w;
  }
}

TEST(PaperImuWeight, ReachesRapidMotionWithinHalfASecondOfImages) {
  PaperImuWeight weight;
  weight.Update({});
  int intervals = 0;
  while (weight.weight() < 0.7 && intervals < 100) {
    weight.Update({.angular_rate = 2.0});
    ++intervals;
  }
  EXPECT_LE(intervals, 15);  // at 30 Hz
  EXPECT_GE(intervals, 8);   // 0.4 in steps of 0.05
}

TEST(PaperImuWeight, HasHysteresis) {
  PaperImuWeight weight;
  const auto settle = [&](double rate) {
    for (int i = 0; i < 50; ++i) weight.Update({.angular_rate = rate});
    return weight.weight();
  };
  settle(0.0);
  const double up = settle(0.6);
  settle(2.0);
  const double down = settle(0.6);
  EXPECT_GT(down, up + 0.1);  // the same motion, reached from above and from below
  // A small oscillation about a settled state has no effect: 0.1 of activity is 0.08 rad/s.
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(weight.Update({.angular_rate = 0.6 + (i % 2 == 0 ? 0.07 : -0.0)}), down);
  }
  // Without hysteresis both directions give the same weight.
  PaperImuWeight plain(PaperImuWeightOptions{.hysteresis = 0.0});
  for (const double rate : {0.0, 0.6}) {
    for (int i = 0; i < 50; ++i) plain.Update({.angular_rate = rate});
  }
  const double plain_up = plain.weight();
  for (const double rate : {2.0, 0.6}) {
    for (int i = 0; i < 50; ++i) plain.Update({.angular_rate = rate});
  }
  EXPECT_NEAR(plain.weight(), plain_up, 1e-15);
}

TEST(PaperImuWeight, TakesAMeasureThatIsNotFiniteForRapidMotion) {
  EXPECT_EQ(PaperImuWeight().Update({.sharpness = kNan}), 0.8);
  EXPECT_EQ(PaperImuWeight().Update({.angular_rate = HUGE_VAL}), 0.8);
}

TEST(PaperImuWeight, RefusesBadOptions) {
  EXPECT_EQ(PaperImuWeight().weight(), 0.3);
  EXPECT_THROW(PaperImuWeight({.weight_at_rest = 0.0}), InvalidArgument);
  EXPECT_THROW(PaperImuWeight({.weight_slow = 0.2}), InvalidArgument);
  EXPECT_THROW(PaperImuWeight({.weight_rapid = 0.39}), InvalidArgument);
  EXPECT_THROW(PaperImuWeight({.weight_max = 1.1}), InvalidArgument);
  for (const MotionRamp& bad : {MotionRamp{1.0, 1.0}, MotionRamp{kNan, 1.0}, {0.0, HUGE_VAL}}) {
    EXPECT_THROW(PaperImuWeight({.angular_rate = bad}), InvalidArgument);
    EXPECT_THROW(PaperImuWeight({.accelerometer_std = bad}), InvalidArgument);
    EXPECT_THROW(PaperImuWeight({.sharpness = bad}), InvalidArgument);
    EXPECT_THROW(PaperImuWeight({.tracked_share = bad}), InvalidArgument);
  }
  EXPECT_THROW(PaperImuWeight({.hysteresis = 0.3}), InvalidArgument);
  EXPECT_THROW(PaperImuWeight({.max_change = 0.0}), InvalidArgument);
}

TEST(ChiSquaredQuantile, MatchesTheTables) {
  // Abramowitz, Stegun, table 26.8.
  EXPECT_NEAR(ChiSquaredQuantile(0.95, 3), 7.815, 0.05);
  EXPECT_NEAR(ChiSquaredQuantile(0.99, 9), 21.666, 0.05);
  EXPECT_NEAR(ChiSquaredQuantile(0.95, 30), 43.773, 0.02);
  EXPECT_NEAR(ChiSquaredQuantile(0.5, 90), 89.33, 0.02);
  EXPECT_THROW(ChiSquaredQuantile(1.0, 3), InvalidArgument);
  EXPECT_THROW(ChiSquaredQuantile(0.5, 0), InvalidArgument);
}

// Returns the squared innovation of nine rows whose covariance is `inflation` times the assumed
// one.
double Innovation(std::mt19937& rng, double inflation) {
  std::chi_squared_distribution<double> chi2(9.0);
  return inflation * chi2(rng);
}

TEST(ConsistentImuWeight, StaysOneWhereTheInnovationsFitTheirCovariance) {
  std::mt19937 rng(8);
  ConsistentImuWeight weight;
  int inflated = 0;
  for (int i = 0; i < 2000; ++i) {
    weight.Update(Innovation(rng, 1.0), 9);
    inflated += weight.IsInflated();
  }
  // A test at the 1 % level on overlapping windows, released at 10 %.
  EXPECT_LT(inflated, 100);
}

TEST(ConsistentImuWeight, FindsTheInflationOfTheCovariance) {
  std::mt19937 rng(9);
  ConsistentImuWeight weight;
  for (int i = 0; i < 40; ++i) weight.Update(Innovation(rng, 4.0), 9);
  double mean = 0.0;
  for (int i = 0; i < 1000; ++i) mean += weight.Update(Innovation(rng, 4.0), 9) / 1000.0;
  EXPECT_TRUE(weight.IsInflated());
  EXPECT_NEAR(mean, 0.25, 0.02);
}

TEST(ConsistentImuWeight, ComesBackAfterADisturbanceWithoutAJump) {
  ConsistentImuWeight weight;
  double previous = 1.0;
  for (int i = 0; i < 100; ++i) {
    const double w = weight.Update(i >= 20 && i < 30 ? 900.0 : 9.0, 9);
    EXPECT_LE(std::max(w / previous, previous / w), 1.25 + 1e-12);
    previous = w;
    if (i == 29) {
      EXPECT_LT(w, 0.2);
    }
  }
  EXPECT_EQ(previous, 1.0);
}

TEST(ConsistentImuWeight, HasHysteresis) {
  // 90 rows: the bounds are 124 (99 %) and 108 (90 %), and 11.6 per innovation adds up to 116.
  const auto after = [](double first) {
    ConsistentImuWeight weight;
    for (int i = 0; i < 20; ++i) weight.Update(first, 9);
    for (int i = 0; i < 20; ++i) weight.Update(11.6, 9);
    return weight.IsInflated();
  };
  EXPECT_FALSE(after(9.0));
  EXPECT_TRUE(after(20.0));
}

TEST(ConsistentImuWeight, IsBounded) {
  ConsistentImuWeight weight;
  for (int i = 0; i < 100; ++i) weight.Update(1e12, 9);
  EXPECT_NEAR(weight.weight(), 0.01, 1e-12);
  for (int i = 0; i < 100; ++i) weight.Update(0.0, 9);
  EXPECT_EQ(weight.weight(), 1.0);
}

TEST(ConsistentImuWeight, RefusesBadArguments) {
  EXPECT_THROW(ConsistentImuWeight({.window = 0}), InvalidArgument);
  EXPECT_THROW(ConsistentImuWeight({.inflate_above = 1.0}), InvalidArgument);
  EXPECT_THROW(ConsistentImuWeight({.release_below = 0.995}), InvalidArgument);
  EXPECT_THROW(ConsistentImuWeight({.max_inflation = 1.0}), InvalidArgument);
  EXPECT_THROW(ConsistentImuWeight({.max_ratio = 0.5}), InvalidArgument);
  ConsistentImuWeight weight;
  EXPECT_THROW(weight.Update(kNan, 9), InvalidArgument);
  EXPECT_THROW(weight.Update(-1.0, 9), InvalidArgument);
  EXPECT_THROW(weight.Update(1.0, 0), InvalidArgument);
}

}  // namespace
}  // namespace highwall::adaptive_imu_weight_test
