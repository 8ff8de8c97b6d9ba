#include "simulate/motion/imu_faults.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/QR>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>

#include "simulate/motion/imu_simulator.h"
#include "simulate/motion/spline_trajectory.h"

namespace highwall::simulate::imu_faults_test {
namespace {

constexpr double kRate = 200.0;

// Returns the readings of a sensor that is rotated and shaken about every axis.
std::vector<ImuSample> Readings(int count) {
  std::vector<ImuSample> readings;
  for (int i = 0; i < count; ++i) {
    const double t = i / kRate;
    readings.push_back(
        {FromSeconds(t),
         {std::sin(2.0 * t), std::cos(3.1 * t), std::sin(4.3 * t + 1.0)},
         {4.0 * std::cos(5.0 * t), 3.0 * std::sin(6.1 * t), 9.81 + std::sin(7.7 * t)}});
  }
  return readings;
}

// Estimates M of y = M x by least squares over all readings; x: [gyroscope accelerometer].
Eigen::Matrix<double, 6, 6> Mixing(const std::vector<ImuSample>& in, const FaultyImu& imu) {
  Eigen::MatrixXd X(static_cast<Eigen::Index>(in.size()), 6), Y(X.rows(), 6);
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    const ImuSample& x = in[static_cast<std::size_t>(i)];
    const ImuSample y = imu.Distorted(x);
    X.row(i) << x.gyroscope.transpose(), x.accelerometer.transpose();
    Y.row(i) << y.gyroscope.transpose(), y.accelerometer.transpose();
  }
  return X.colPivHouseholderQr().solve(Y).transpose();
}

TEST(FaultyImu, WithoutFaultsItIsTheSensorItself) {
  const FaultyImu imu({}, CounterRandom(1), kRate);
  const std::vector<ImuSample> readings = Readings(100);
  const std::vector<ImuSample> delivered = imu.Delivered(readings);
  ASSERT_EQ(delivered.size(), readings.size());
  for (std::size_t i = 0; i < readings.size(); ++i) {
    EXPECT_EQ(delivered[i].stamp, readings[i].stamp);
    EXPECT_EQ(delivered[i].gyroscope, readings[i].gyroscope);
    EXPECT_EQ(imu.Distorted(readings[i]).gyroscope, readings[i].gyroscope);
    EXPECT_EQ(imu.Distorted(readings[i]).accelerometer, readings[i].accelerometer);
  }
  EXPECT_EQ(imu.DriftAt(1000.0), ImuBias(ImuBias::Zero()));
}

TEST(FaultyImu, ScalesAxesAndGravityAreOffByTheirSigmas) {
  const ImuFaults faults{.gyroscope_scale = 0.01,
                         .accelerometer_scale = 0.02,
                         .misalignment = 0.005,
                         .g_sensitivity = 0.003};
  const std::vector<ImuSample> readings = Readings(400);
  double gyroscope = 0.0, accelerometer = 0.0, axes = 0.0, gravity = 0.0, none = 0.0;
  constexpr int kSeeds = 400;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto M = Mixing(readings, FaultyImu(faults, CounterRandom(seed), kRate));
    const Eigen::Matrix<double, 6, 6> off = M - Eigen::Matrix<double, 6, 6>::Identity();
    for (Eigen::Index i = 0; i < 3; ++i) {
      gyroscope += std::pow(off(i, i) / 0.01, 2) / (3 * kSeeds);
      accelerometer += std::pow(off(3 + i, 3 + i) / 0.02, 2) / (3 * kSeeds);
      for (Eigen::Index j = 0; j < 3; ++j) {
        if (i != j) axes += std::pow(off(i, j) / 0.005, 2) / (12 * kSeeds);
        if (i != j) axes += std::pow(off(3 + i, 3 + j) / 0.005, 2) / (12 * kSeeds);
        gravity += std::pow(off(i, 3 + j) / 0.003, 2) / (9 * kSeeds);
        none = std::max(none, std::abs(off(3 + i, j)));
      }
    }
  }
  // Means of chi-squared of n degrees of freedom: the tolerance is four sigmas, sqrt(2 / n).
  EXPECT_NEAR(gyroscope, 1.0, 4.0 * std::sqrt(2.0 / (3 * kSeeds)));
  EXPECT_NEAR(accelerometer, 1.0, 4.0 * std::sqrt(2.0 / (3 * kSeeds)));
  EXPECT_NEAR(axes, 1.0, 4.0 * std::sqrt(2.0 / (12 * kSeeds)));
  EXPECT_NEAR(gravity, 1.0, 4.0 * std::sqrt(2.0 / (9 * kSeeds)));
  EXPECT_LT(none, 1e-12) << "an accelerometer feels no turning";
}

TEST(FaultyImu, ReadsNoMoreThanItsRange) {
  const FaultyImu imu({.gyroscope_range = 0.5, .accelerometer_range = 3.5}, CounterRandom(1),
                      kRate);
  const std::vector<ImuSample> readings = Readings(400), delivered = imu.Delivered(readings);
  int clipped = 0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    EXPECT_LE(delivered[i].gyroscope.cwiseAbs().maxCoeff(), 0.5);
    EXPECT_LE(delivered[i].accelerometer.cwiseAbs().maxCoeff(), 3.5);
    for (Eigen::Index k = 0; k < 3; ++k) {
      if (std::abs(readings[i].gyroscope(k)) <= 0.5) {
        EXPECT_EQ(delivered[i].gyroscope(k), readings[i].gyroscope(k));
      } else {
        EXPECT_EQ(delivered[i].gyroscope(k), std::copysign(0.5, readings[i].gyroscope(k)));
        ++clipped;
      }
    }
  }
  EXPECT_GT(clipped, 100);
}

TEST(FaultyImu, WarmsUpExponentially) {
  const FaultyImu imu({.gyroscope_drift = 0.01, .accelerometer_drift = 0.2, .warm_up = 30.0},
                      CounterRandom(4), kRate);
  const ImuBias all = imu.DriftAt(1e9);
  EXPECT_GT(all.head<3>().norm(), 1e-3);
  EXPECT_GT(all.tail<3>().norm(), 2e-2);
  EXPECT_EQ(imu.DriftAt(0.0), ImuBias(ImuBias::Zero()));
  EXPECT_TRUE(imu.DriftAt(30.0).isApprox((1.0 - std::exp(-1.0)) * all, 1e-12));
}

TEST(FaultyImu, LosesReadingsAndStampsThemLateOrEarlyButInOrder) {
  const ImuFaults faults{.stamp_jitter = 5e-4, .dropped = 0.1};
  const FaultyImu imu(faults, CounterRandom(7), kRate);
  constexpr int kCount = 20000;
  const std::vector<ImuSample> delivered = imu.Delivered(Readings(kCount));
  // Binomial distribution: the tolerance is four sigmas.
  EXPECT_NEAR(static_cast<double>(delivered.size()), 0.9 * kCount, 4.0 * std::sqrt(0.09 * kCount));
  double squares = 0.0;
  for (std::size_t i = 0; i < delivered.size(); ++i) {
    const double seconds = ToSeconds(delivered[i].stamp);
    const double off = seconds - std::round(seconds * kRate) / kRate;
    EXPECT_LE(std::abs(off), 0.2 / kRate + 1e-9);
    squares += off * off;
    if (i > 0) {
      EXPECT_GT(delivered[i].stamp, delivered[i - 1].stamp);
    }
  }
  // Truncated at two sigmas: 1 - (4 phi(2) - 2 * 4 * Phi(-2)) = 0.923 of the variance remains.
  const double sigma = std::sqrt(squares / static_cast<double>(delivered.size()));
  EXPECT_NEAR(sigma, 5e-4 * std::sqrt(0.923), 1e-5);
}

TEST(FaultyImu, SimulatesOneShockInEachInterval) {
  const FaultyImu imu({.blow_interval = 4.0}, CounterRandom(3), kRate);
  const std::vector<ImuSample> readings = Readings(8000), delivered = imu.Delivered(readings);
  int blows = 0, struck = 0;
  double hardest = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const double off = (delivered[i].accelerometer - readings[i].accelerometer).norm();
    if (off > 0.0 && struck == 0) ++blows;
    struck = off > 0.0 ? 12 : std::max(struck - 1, 0);  // 60 ms
    hardest = std::max(hardest, off);
    EXPECT_NEAR((delivered[i].gyroscope - readings[i].gyroscope).norm(), 3.0 / 40.0 * off, 1e-9);
  }
  EXPECT_GE(blows, 9) << "in 40 s; the last span's may come too late, two may touch";
  EXPECT_LE(blows, 10);
  // A reading lies within 2.5 ms of the middle of each shock.
  EXPECT_LE(hardest, 40.0);
  EXPECT_GT(hardest, 39.5);
}

TEST(ImuFaults, AreReadFromTheirNames) {
  EXPECT_EQ(ParseImuFaults("off").gyroscope_scale, 0.0);
  EXPECT_EQ(ParseImuFaults("hard").dropped, HardImuFaults().dropped);
  const ImuFaults some = ParseImuFaults("hard,dropped=0,gyroscope_range=2.5");
  EXPECT_EQ(some.dropped, 0.0);
  EXPECT_EQ(some.gyroscope_range, 2.5);
  EXPECT_EQ(some.misalignment, HardImuFaults().misalignment);
  const auto message = [](const std::string& text) -> std::string {
    try {
      ParseImuFaults(text);
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message("soft").find("'soft' is no fault"), std::string::npos);
  EXPECT_NE(message("dropped").find("'dropped' is no fault"), std::string::npos);
  EXPECT_NE(message("dropped=half").find("dropped must be a number"), std::string::npos);
  EXPECT_NE(message("dropped=0.9").find("dropped is out of range"), std::string::npos);
  EXPECT_NE(message("warm_up=0").find("warm_up is out of range"), std::string::npos);
  EXPECT_NE(message("misalignment=nan").find("misalignment"), std::string::npos);
}

// The IMU is at rest with negligible noise: the error of the readings equals the bias that the
// simulator states.
TEST(ImuSimulator, TheTrueBiasWarmsUpWithTheSensor) {
  constexpr Stamp kBegin = 1'000'000'000;
  const CameraPath path(SplineTrajectory(std::vector<Pose>(4), 10.0), 0.0);
  ImuSimulationOptions options;
  options.noise_ratio = 1e-6;
  options.gyroscope_bias = options.accelerometer_bias = 0.0;
  options.faults = {.accelerometer_drift = 0.3, .warm_up = 2.0};
  const ImuSimulator imu(options, 3, kBegin, kBegin + FromSeconds(8.0));
  ImuSimulationOptions sound = options;
  sound.faults = {};
  const auto readings = imu.Samples(path, {});
  const auto reference =
      ImuSimulator(sound, 3, kBegin, kBegin + FromSeconds(8.0)).Samples(path, {});
  ASSERT_EQ(readings.size(), reference.size());
  double most = 0.0;
  for (std::size_t i = 100; i + 100 < readings.size(); ++i) {
    const Eigen::Vector3d drift = readings[i].accelerometer - reference[i].accelerometer;
    const ImuBias bias = imu.StateAt(path, {}, readings[i].stamp).bias;
    // The random walks are scaled by a millionth.
    EXPECT_LT((drift - bias.tail<3>()).norm(), 1e-6) << i;
    most = std::max(most, drift.norm());
  }
  EXPECT_GT(most, 0.05);
}

}  // namespace
}  // namespace highwall::simulate::imu_faults_test
