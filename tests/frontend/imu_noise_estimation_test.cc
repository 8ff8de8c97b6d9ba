#include <highwall/frontend/calibration/imu_noise_estimation.h>

#include <cmath>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>

#include "support/noise_at_rest.h"

namespace highwall::imu_noise_estimation_test {
namespace {

const ImuNoise kNoise{
    .gyroscope = 1.7e-4, .accelerometer = 2e-3, .gyroscope_walk = 2e-5, .accelerometer_walk = 3e-4};
constexpr double kHertz = 200.0;

// Adds a rotation and a sway from `begin` to `end` [s].
void Move(double begin, double end, std::vector<ImuSample>* samples) {
  for (ImuSample& sample : *samples) {
    const double t = ToSeconds(sample.stamp);
    if (t < begin || t >= end) continue;
    sample.gyroscope.x() += 0.4 * std::sin(7.0 * (t - begin));
    sample.accelerometer.y() += 1.5 * std::sin(9.0 * (t - begin));
  }
}

double Seconds(std::size_t readings) {
  return static_cast<double>(readings) / kHertz;
}

TEST(FindRest, FindsTheStretchesBetweenMotions) {
  auto samples = ImuAtRest(1, 40.0, kHertz, kNoise);
  Move(10.0, 18.0, &samples);
  Move(20.0, 25.0, &samples);  // the 2 s in between are too short
  const auto rest = FindRest(samples);
  ASSERT_EQ(rest.size(), 2U);
  // Only windows of half a second that are stationary as a whole count.
  EXPECT_EQ(rest[0].begin, 0U);
  EXPECT_LE(Seconds(rest[0].end), 10.0);
  EXPECT_GE(Seconds(rest[0].end), 9.4);
  EXPECT_GE(Seconds(rest[1].begin), 25.0);
  EXPECT_LE(Seconds(rest[1].begin), 25.6);
}

TEST(FindRest, AGapEndsARest) {
  auto samples = ImuAtRest(2, 20.0, kHertz, kNoise);
  samples.erase(samples.begin() + 2'000, samples.begin() + 2'003);
  const auto rest = FindRest(samples);
  ASSERT_EQ(rest.size(), 2U);
  EXPECT_LE(rest[0].end, 2'000U);
  EXPECT_GE(rest[1].begin, 2'000U);
}

TEST(FindRest, RejectsAHandHeldStillWhereATableGivesRest) {
  auto samples = ImuAtRest(3, 30.0, kHertz, kNoise);
  for (std::size_t i = 2'000; i < 4'000; ++i) {  // tremor, below the threshold of IsStationary
    samples[i].gyroscope.y() += 0.008 * std::sin(2.0 * M_PI * 9.0 * ToSeconds(samples[i].stamp));
  }
  ASSERT_TRUE(IsStationary(std::span(samples).subspan(2'500, 100)));
  constexpr std::size_t kWindow = 101;  // it may contain the beginning or the end of the tremor
  for (const ReadingRange& range : FindRest(samples)) {
    EXPECT_TRUE(range.end < 2'000 + kWindow || range.begin > 4'000 - kWindow)
        << range.begin << " " << range.end;
  }
}

TEST(FindRest, FindsNoneInMotionAndInTooFewReadings) {
  auto samples = ImuAtRest(4, 10.0, kHertz, kNoise);
  EXPECT_TRUE(FindRest(std::span(samples).first(1)).empty());
  EXPECT_TRUE(FindRest({}).empty());
  Move(0.0, 10.0, &samples);
  EXPECT_TRUE(FindRest(samples).empty());
}

TEST(EstimateImuNoise, FindsTheDensitiesOfTenMinutes) {
  const auto samples = ImuAtRest(5, 600.0, kHertz, kNoise);
  const ImuNoiseEstimate estimate = *EstimateImuNoise(samples, FindRest(samples));
  EXPECT_NEAR(estimate.step, 1.0 / kHertz, 1e-9);
  const auto holds = [](const NoiseDensity& density, double truth) {
    return density.low <= truth && truth <= density.high;
  };
  EXPECT_TRUE(holds(estimate.gyroscope.all.white, kNoise.gyroscope));
  EXPECT_TRUE(holds(estimate.gyroscope.all.walk, kNoise.gyroscope_walk));
  EXPECT_TRUE(holds(estimate.accelerometer.all.white, kNoise.accelerometer));
  EXPECT_TRUE(holds(estimate.accelerometer.all.walk, kNoise.accelerometer_walk));
  // The tolerance is the interval of one seed, with a model error of 5 % over nine octaves.
  EXPECT_NEAR(estimate.gyroscope.all.white.value, kNoise.gyroscope, 0.05 * kNoise.gyroscope);
  EXPECT_NEAR(estimate.accelerometer.all.white.value, kNoise.accelerometer,
              0.05 * kNoise.accelerometer);
  EXPECT_NEAR(estimate.gyroscope.all.walk.value, kNoise.gyroscope_walk,
              0.4 * kNoise.gyroscope_walk);
}

TEST(EstimateImuNoise, EstimatesEachAxisByItself) {
  auto samples = ImuAtRest(6, 120.0, kHertz, kNoise);
  for (ImuSample& sample : samples) {
    sample.accelerometer.z() = 9.81 + 3.0 * (sample.accelerometer.z() - 9.81);
  }
  const SensorNoise noise = EstimateImuNoise(samples, FindRest(samples))->accelerometer;
  EXPECT_NEAR(noise.axes[2].white.value / noise.axes[0].white.value, 3.0, 0.3);
  // Root mean square of 1, 1 and 3.
  EXPECT_NEAR(noise.all.white.value / kNoise.accelerometer, std::sqrt(11.0 / 3.0), 0.1);
}

TEST(EstimateImuNoise, AFewSecondsShowTheWhiteNoiseAndBoundTheWalk) {
  const auto samples = ImuAtRest(7, 8.0, kHertz, kNoise);
  const ImuNoiseEstimate estimate = *EstimateImuNoise(samples, FindRest(samples));
  EXPECT_TRUE(estimate.gyroscope.all.white.IsSeen());
  EXPECT_FALSE(estimate.gyroscope.all.walk.IsSeen());
  EXPECT_GT(estimate.gyroscope.all.walk.high, kNoise.gyroscope_walk);
}

TEST(EstimateImuNoise, StampsRoundedToAMillisecondAreNoGaps) {
  auto samples = ImuAtRest(9, 60.0, 800.0, kNoise);
  for (ImuSample& sample : samples) {
    sample.stamp = (sample.stamp + 500'000) / 1'000'000 * 1'000'000;
  }
  const auto rest = FindRest(samples);
  ASSERT_EQ(rest.size(), 1U);
  const ImuNoiseEstimate estimate = *EstimateImuNoise(samples, rest);
  EXPECT_NEAR(estimate.step, 1.0 / 800.0, 1e-6);
  EXPECT_NEAR(estimate.gyroscope.all.white.value, kNoise.gyroscope, 0.05 * kNoise.gyroscope);
}

TEST(EstimateImuNoise, AnAxisThatRepeatsOneValueIsNotSeenAndTheOthersAre) {
  auto samples = ImuAtRest(10, 30.0, kHertz, kNoise);
  for (ImuSample& sample : samples) sample.gyroscope.y() = 0.001;
  const SensorNoise noise = EstimateImuNoise(samples, FindRest(samples))->gyroscope;
  EXPECT_FALSE(noise.axes[1].white.IsSeen());
  EXPECT_NEAR(noise.axes[0].white.value, kNoise.gyroscope, 0.1 * kNoise.gyroscope);
}

TEST(EstimateImuNoise, AGapPartsAStretch) {
  auto samples = ImuAtRest(11, 40.0, kHertz, kNoise);
  for (std::size_t i = 4'000; i < samples.size(); ++i) {
    samples[i].stamp += FromSeconds(1000.0);
    samples[i].gyroscope.x() += 0.01;  // the bias has changed in between
  }
  const std::vector<ReadingRange> all = {{0, samples.size()}};
  const ImuNoiseEstimate estimate = *EstimateImuNoise(samples, all);
  EXPECT_NEAR(estimate.step, 1.0 / kHertz, 1e-6);
  EXPECT_NEAR(estimate.gyroscope.axes[0].white.value, kNoise.gyroscope, 0.1 * kNoise.gyroscope);
  EXPECT_FALSE(estimate.gyroscope.axes[0].walk.IsSeen());
}

TEST(EstimateImuNoise, TooFewReadingsOrReadingsThatNeverChangeGiveNone) {
  auto samples = ImuAtRest(8, 5.0, kHertz, kNoise);
  EXPECT_FALSE(EstimateImuNoise({}, {}));
  EXPECT_FALSE(EstimateImuNoise(samples, {}));
  const std::vector<ReadingRange> brief = {{0, 47}}, all = {{0, samples.size()}};
  EXPECT_FALSE(EstimateImuNoise(samples, brief));
  EXPECT_TRUE(EstimateImuNoise(samples, all));
  for (ImuSample& sample : samples) sample.gyroscope.setZero();
  EXPECT_FALSE(EstimateImuNoise(samples, all));
}

TEST(EstimateImuNoise, RefusesStretchesOutsideAndBadOptions) {
  const auto samples = ImuAtRest(8, 5.0, kHertz, kNoise);
  const std::vector<ReadingRange> outside = {{500, 1'001}};
  EXPECT_THROW(EstimateImuNoise(samples, outside), InvalidArgument);
  EXPECT_THROW(FindRest(samples, {.max_variance_ratio = 1.0}), InvalidArgument);
  EXPECT_THROW(FindRest(samples, {.window = 0.0}), InvalidArgument);
  EXPECT_THROW(FindRest(samples, {.min_readings = 0}), InvalidArgument);
  auto backwards = samples;
  std::swap(backwards[10].stamp, backwards[11].stamp);
  EXPECT_THROW(FindRest(backwards), InvalidArgument);
}

}  // namespace
}  // namespace highwall::imu_noise_estimation_test
