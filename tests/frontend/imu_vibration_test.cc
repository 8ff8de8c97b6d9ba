#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "inertial/imu_vibration.h"
#include "support/imu_scene.h"

namespace highwall::imu_vibration_test {
namespace {

// Adds white noise of one sigma to every axis of the accelerometer.
std::vector<ImuSample> Shaken(std::vector<ImuSample> samples, double sigma) {
  std::mt19937 rng(7);
  std::normal_distribution<double> normal(0.0, sigma);
  for (ImuSample& sample : samples) {
    for (double& a : sample.accelerometer) a += normal(rng);
  }
  return samples;
}

TEST(AccelerometerShake, IsTheStandardDeviationOfWhiteNoise) {
  const std::vector<ImuSample> rest = SinusoidalMotion(0.0).Samples(200.0, 10.0);
  // 6000 second differences, each with a variance known to sqrt(2 / n) times 1.8 for their
  // correlation.
  EXPECT_NEAR(AccelerometerShake(Shaken(rest, 0.5)), 0.5, 4.0 * 0.5 * 0.018);
}

TEST(AccelerometerShake, SmoothMotionAndAnyConstantAreNoShaking) {
  EXPECT_LT(AccelerometerShake(SinusoidalMotion(0.0).Samples(200.0, 1.0)), 1e-13);
  const auto moving = SinusoidalMotion(1.0).Samples(200.0, 2.0);
  // Smooth motion gives a w^2 h^2 / sqrt(18), here of some 10 m/s^2 at 3 rad/s and 5 ms.
  EXPECT_LT(AccelerometerShake(moving), 1e-3);
  const ImuBias bias = (ImuBias() << 0, 0, 0, 1, -2, 3).finished();
  EXPECT_NEAR(AccelerometerShake(WithBias(moving, bias)), AccelerometerShake(moving), 1e-13);
}

TEST(AccelerometerShake, IsZeroForTooFewReadings) {
  const auto samples = Shaken(SinusoidalMotion().Samples(200.0, 0.01), 1.0);
  ASSERT_EQ(samples.size(), 3u);
  EXPECT_GT(AccelerometerShake(samples), 0.0);
  EXPECT_EQ(AccelerometerShake(std::span(samples).first(2)), 0.0);
  EXPECT_EQ(AccelerometerShake({}), 0.0);
}

TEST(ShakenNoise, LeavesACalmImuAsItIs) {
  const ImuNoise noise;
  const ImuNoise calm = ShakenNoise(noise, SinusoidalMotion(0.0).Samples(200.0, 0.1));
  EXPECT_DOUBLE_EQ(calm.accelerometer, noise.accelerometer);
  EXPECT_EQ(calm.gyroscope, noise.gyroscope);
  EXPECT_EQ(calm.gyroscope_walk, noise.gyroscope_walk);
  EXPECT_EQ(calm.accelerometer_walk, noise.accelerometer_walk);
}

TEST(ShakenNoise, AddsTheSameVelocityWhateverTheLengthOfTheInterval) {
  const ImuNoise noise;
  const auto samples = Shaken(SinusoidalMotion(0.0).Samples(200.0, 2.0), 2.0);
  for (const std::size_t readings : {21u, 201u}) {
    const std::span<const ImuSample> part = std::span(samples).first(readings);
    const double duration = 0.005 * static_cast<double>(readings - 1);
    const ImuNoise shaken = ShakenNoise(noise, part, 0.5);
    // The velocity variance of a density q over T is q^2 T.
    const double added =
        (shaken.accelerometer * shaken.accelerometer - noise.accelerometer * noise.accelerometer) *
        duration;
    EXPECT_NEAR(std::sqrt(added), 0.5 * AccelerometerShake(part) * 0.005, 1e-12) << readings;
    EXPECT_EQ(shaken.gyroscope, noise.gyroscope);
  }
  EXPECT_GT(ShakenNoise(noise, samples, 0.5).accelerometer,
            ShakenNoise(noise, samples, 0.25).accelerometer);
}

TEST(ShakenNoise, ShortStepsAtTheEndsMakeNoReadingMissing) {
  // Images of arbitrary rate and phase cut an interval anywhere between two readings.
  constexpr double kRate = 200.0, kShare = 0.5;
  for (const double duration : {0.008, 0.011, 0.0167, 0.0333, 0.1}) {
    for (int phase = 1; phase < 20; ++phase) {
      const double begin = 1.0 + phase / 20.0 / kRate, end = begin + duration;
      std::vector<ImuSample> samples = Shaken(SinusoidalMotion(0.0).Samples(kRate, 1.5), 2.0);
      const ImuSample still = samples.front();
      std::erase_if(samples, [&](const ImuSample& sample) {
        const double t = ToSeconds(sample.stamp);
        return t <= begin || t >= end;
      });
      ImuSample first = still, last = still;
      first.stamp = FromSeconds(begin);
      last.stamp = FromSeconds(end);
      samples.insert(samples.begin(), first);
      samples.push_back(last);
      const double step = duration / static_cast<double>(samples.size() - 1);
      const double added = kShare * AccelerometerShake(samples) * step / std::sqrt(duration);
      const ImuNoise shaken = ShakenNoise({}, samples, kShare);
      EXPECT_NEAR(shaken.accelerometer, std::hypot(ImuNoise().accelerometer, added), 1e-12)
          << duration << " from " << begin;
    }
  }
}

TEST(ShakenNoise, CoversTheVelocityErrorOfAVibrationThatIsCutOff) {
  // 70 Hz sampled at 200 Hz, cut at 100 phases: the integrated velocity is off, while the true one
  // does not change on average.
  constexpr double kAmplitude = 3.0, kOmega = 2.0 * M_PI * 70.0, kDuration = 0.1;
  double squares = 0.0, claimed = 0.0;
  constexpr int kPhases = 100;
  for (int phase = 0; phase < kPhases; ++phase) {
    const double phi = 2.0 * M_PI * phase / kPhases;
    std::vector<ImuSample> samples = SinusoidalMotion(0.0).Samples(200.0, kDuration);
    const ImuSample still = samples.front();
    for (ImuSample& sample : samples) {
      sample.accelerometer.x() += kAmplitude * std::cos(kOmega * ToSeconds(sample.stamp) + phi);
    }
    const ImuPreintegration imu(samples, ImuBias::Zero());
    const double truth = kAmplitude / kOmega * (std::sin(kOmega * kDuration + phi) - std::sin(phi));
    const double error = imu.delta().v.x() - still.accelerometer.x() * kDuration - truth;
    squares += error * error;
    const ImuNoise shaken = ShakenNoise({}, samples);
    claimed += shaken.accelerometer * shaken.accelerometer * kDuration;
  }
  const double rms = std::sqrt(squares / kPhases), sigma = std::sqrt(claimed / kPhases);
  EXPECT_GT(rms, 1e-3) << "the vibration must matter";
  EXPECT_LT(rms, 3.0 * sigma);
}

TEST(ShakenNoise, CoversTheVelocityErrorOfReadingsThatAreMissing) {
  // White vibration, whose velocity is known from all readings; one reading, or three in a row, are
  // removed. The mean of 400 squared errors on three axes is known to 4 %; the gap is interpolated
  // by a cubic, whose error is up to twice that of a straight line.
  constexpr double kShake = 2.0, kDuration = 0.1;
  for (const std::ptrdiff_t count : {1, 3}) {
    double ratio = 0.0;
    constexpr int kSeeds = 400;
    for (int seed = 0; seed < kSeeds; ++seed) {
      std::mt19937 rng(static_cast<unsigned>(seed));
      std::normal_distribution<double> normal(0.0, kShake);
      std::vector<ImuSample> samples = SinusoidalMotion(0.0).Samples(200.0, kDuration);
      for (ImuSample& sample : samples) {
        for (double& a : sample.accelerometer) a += normal(rng);
      }
      const ImuPreintegration all(samples, ImuBias::Zero());
      const double claimed_of_all = ShakenNoise({}, samples).accelerometer;
      samples.erase(samples.begin() + 8, samples.begin() + 8 + count);
      const ImuPreintegration some(samples, ImuBias::Zero());
      const double claimed = ShakenNoise({}, samples).accelerometer;
      ASSERT_GT(claimed, claimed_of_all);
      ratio +=
          (some.delta().v - all.delta().v).squaredNorm() / (3.0 * claimed * claimed * kDuration);
    }
    EXPECT_GT(ratio / kSeeds, 0.3) << count;
    EXPECT_LT(ratio / kSeeds, 2.0) << count;
  }
}

TEST(ShakenNoise, TakesNoShortStepAtTheEndsForAGap) {
  auto samples = Shaken(SinusoidalMotion(0.0).Samples(200.0, 0.1), 2.0);
  const double before = ShakenNoise({}, samples).accelerometer;
  samples.front().stamp += FromSeconds(0.003);
  samples.back().stamp -= FromSeconds(0.002);
  EXPECT_NEAR(ShakenNoise({}, samples).accelerometer, before, 0.05 * before);
}

}  // namespace
}  // namespace highwall::imu_vibration_test
