#include "simulate/motion/imu_simulator.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/factors/imu_factor.h>

#include "simulate/scenes/room.h"

namespace highwall::simulate::imu_simulator_test {
namespace {

constexpr Stamp kBegin = 1'000'000'000;
const Eigen::Vector3d kGravity_W(0.0, 0.0, -kStandardGravity);

CameraPath Walk(double rest = 0.0) {
  // The knots of 19.7 s are 0.788 s apart, so they lie between the readings.
  return CameraPath(MakeRoomTrajectory(19.7, 1), rest);
}

CameraPath StandingStill() {
  return CameraPath(SplineTrajectory(std::vector<Pose>(4), 10.0), 0.0);
}

ImuSimulationOptions Ideal(double rate = 200.0) {
  ImuSimulationOptions options;
  options.ideal = true;
  options.rate = rate;
  return options;
}

ImuSimulator Simulator(const ImuSimulationOptions& options, double duration,
                       std::uint64_t seed = 1) {
  return ImuSimulator(options, seed, kBegin, kBegin + FromSeconds(duration));
}

ImuBuffer Buffer(const std::vector<ImuSample>& samples) {
  ImuBuffer buffer({.horizon = 1e6});
  for (const ImuSample& sample : samples) {
    EXPECT_EQ(buffer.Add(sample), ImuSampleStatus::kAdded);
  }
  return buffer;
}

double Rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// Returns the largest errors of position, velocity and rotation after windows of `length` [s] on
// [0, duration], predicted from the true state at their start.
double PredictionError(const ImuSimulator& imu, const CameraPath& path, double time_offset,
                       double duration, double length) {
  const ImuBuffer buffer = Buffer(imu.Samples(path, {}));
  const Stamp offset = FromSeconds(time_offset);
  double worst = 0.0;
  for (double t = 0.0; t + length <= duration; t += length) {
    const TrueState from = imu.StateAt(path, {}, kBegin + FromSeconds(t));
    const TrueState to = imu.StateAt(path, {}, kBegin + FromSeconds(t + length));
    const auto interval = buffer.Between(from.stamp + offset, to.stamp + offset);
    EXPECT_TRUE(interval.has_value());
    const ImuPreintegration delta(interval->samples, from.bias);
    const ImuState predicted = delta.Predict(from.state, from.bias, kGravity_W);
    const Pose error = predicted.T_WB.Inverse() * to.state.T_WB;
    worst =
        std::max({worst, error.p().norm(), error.Angle(), (predicted.v_WB - to.state.v_WB).norm()});
  }
  return worst;
}

// Returns the differences between central differences of width h and the motion's own derivatives:
// velocity, angular velocity, acceleration, angular acceleration.
Eigen::Vector4d DifferenceErrors(const std::function<CameraMotion(double)>& motion_at, double t,
                                 double h) {
  const CameraMotion at = motion_at(t), before = motion_at(t - h), after = motion_at(t + h);
  const Eigen::Vector3d v = (after.T_WC.p() - before.T_WC.p()) / (2 * h);
  const Eigen::Vector3d w = (so3::Log(at.T_WC.q().conjugate() * after.T_WC.q()) -
                             so3::Log(at.T_WC.q().conjugate() * before.T_WC.q())) /
                            (2 * h);
  return {(v - at.v_WC).norm(), (w - at.w_C).norm(),
          ((after.v_WC - before.v_WC) / (2 * h) - at.a_WC).norm(),
          ((after.w_C - before.w_C) / (2 * h) - at.alpha_C).norm()};
}

TEST(SplineTrajectory, ItsMotionIsTheDerivativeOfItsPose) {
  const SplineTrajectory spline = MakeRoomTrajectory(20.0, 3);
  const double knot = 20.0 / 25.0;  // [s], of 25 knots
  for (int i = 0; i < 25; ++i) {
    const double t = (i + 0.4) * knot;  // not at the knots, where the third derivative jumps
    const auto motion = [&spline](double s) { return spline.MotionAt(s); };
    // Second order: h^2 / 6 times the third derivative, which is below 10 here.
    EXPECT_LT(DifferenceErrors(motion, t, 1e-4).maxCoeff(), 2e-8);
    const Eigen::Vector4d coarse = DifferenceErrors(motion, t, 0.1);
    const Eigen::Vector4d fine = DifferenceErrors(motion, t, 0.05);
    EXPECT_LT(fine[0], 0.26 * coarse[0] + 1e-12);
    EXPECT_LT(fine[1], 0.3 * coarse[1] + 1e-12);
    EXPECT_EQ(spline.T_WC(t).p(), motion(t).T_WC.p());
  }
}

TEST(SplineTrajectory, ItsMotionIsContinuousAcrossKnots) {
  const SplineTrajectory spline = MakeRoomTrajectory(20.0, 3);
  constexpr double kStep = 1e-9;  // [s]; times a third derivative below 10
  for (int i = 0; i < 25; ++i) {
    const CameraMotion before = spline.MotionAt(i * 0.8 - kStep);
    const CameraMotion after = spline.MotionAt(i * 0.8 + kStep);
    EXPECT_LT((after.a_WC - before.a_WC).norm(), 1e-7);
    EXPECT_LT((after.alpha_C - before.alpha_C).norm(), 1e-7);
  }
}

TEST(CameraPath, StandsStillAndThenFollowsTheSpline) {
  const CameraPath path = Walk(2.0);
  const SplineTrajectory spline = MakeRoomTrajectory(19.7, 1);
  for (const double t : {-0.5, 0.0, 1.0, 2.0}) {
    const CameraMotion motion = path.MotionAt(t);
    EXPECT_EQ(motion.T_WC.p(), spline.T_WC(0.0).p());
    EXPECT_EQ(motion.v_WC.norm() + motion.a_WC.norm(), 0.0);
    EXPECT_EQ(motion.w_C.norm() + motion.alpha_C.norm(), 0.0);
  }
  EXPECT_LT((path.T_WC(7.5).p() - spline.T_WC(5.0).p()).norm(), 1e-12);
  EXPECT_LT((path.MotionAt(7.5).a_WC - spline.MotionAt(5.0).a_WC).norm(), 1e-12);
  EXPECT_EQ(CameraPath::MovingTime(12.5, 2.0), 10.0);
  EXPECT_EQ(CameraPath::MovingTime(12.5, 0.0), 12.5);
}

TEST(CameraPath, GathersSpeedSmoothly) {
  const CameraPath path = Walk(2.0);
  for (double t = 2.01; t < 3.05; t += 0.0217) {
    const auto motion = [&path](double s) { return path.MotionAt(s); };
    // h^2 / 6 times third derivatives of the speed below 60 / s^3.
    EXPECT_LT(DifferenceErrors(motion, t, 1e-4).maxCoeff(), 2e-7) << t;
  }
  EXPECT_THROW(Walk(-1.0), InvalidArgument);
}

TEST(ImuSimulator, IdealReadingsPredictTheTrueStates) {
  // Within a second the slope of the acceleration jumps at one or two knots by some m/s^3. The step
  // that contains a knot has an error of h^2 / 12 of that; all others are of fourth order.
  const double coarse = PredictionError(Simulator(Ideal(200.0), 20.0), Walk(), 0.0, 20.0, 1.0);
  const double fine = PredictionError(Simulator(Ideal(1000.0), 20.0), Walk(), 0.0, 20.0, 1.0);
  EXPECT_LT(coarse, 5e-6);
  EXPECT_LT(fine, 2e-7);  // 25 times less
}

TEST(ImuSimulator, FeelsGravityAloneAtRest) {
  const CameraPath path = Walk(3.0);
  const ImuSimulator imu = Simulator(Ideal(), 2.0);
  const TrueState truth = imu.StateAt(path, {}, kBegin);
  EXPECT_EQ(truth.state.v_WB.norm(), 0.0);
  for (const ImuSample& sample : imu.Samples(path, {})) {
    EXPECT_EQ(sample.gyroscope.norm(), 0.0);
    // The tolerance covers the rounding of 9.81.
    EXPECT_LT((truth.state.T_WB.q() * sample.accelerometer + kGravity_W).norm(), 1e-14);
  }
}

TEST(ImuSimulator, ReachesHalfASecondBeyondTheVideoInEitherClock) {
  for (const double time_offset : {-0.2, 0.0, 0.03}) {
    ImuSimulationOptions options = Ideal();
    options.time_offset = time_offset;
    const std::vector<ImuSample> samples = Simulator(options, 3.0).Samples(Walk(), {});
    const Stamp offset = FromSeconds(time_offset);
    const Stamp first = std::min(kBegin, kBegin + offset), last = std::max<Stamp>(offset, 0);
    EXPECT_LE(samples.front().stamp, first - FromSeconds(0.5));
    EXPECT_GE(samples.back().stamp, kBegin + FromSeconds(3.5) + last);
    EXPECT_GT(samples.front().stamp, 0);
  }
}

TEST(ImuSimulator, TheOffsetMovesTheStampsOfTheReadings) {
  ImuSimulationOptions options = Ideal();
  options.time_offset = 0.03;
  const ImuSimulator imu = Simulator(options, 5.0);
  EXPECT_LT(PredictionError(imu, Walk(), 0.03, 5.0, 1.0), 1e-5);
  // Ignoring it causes errors of millimetres.
  EXPECT_GT(PredictionError(imu, Walk(), 0.0, 5.0, 1.0), 1e-3);
}

// Returns the Allan deviation at tau = cluster / rate, over all axes of one sensor.
double AllanDeviation(const std::vector<ImuSample>& samples, Eigen::Vector3d ImuSample::*sensor,
                      std::size_t cluster) {
  std::vector<double> differences;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    double previous = 0.0;
    for (std::size_t begin = 0; begin + cluster <= samples.size(); begin += cluster) {
      double mean = 0.0;
      for (std::size_t i = begin; i < begin + cluster; ++i) mean += (samples[i].*sensor)[axis];
      mean /= static_cast<double>(cluster);
      if (begin > 0) differences.push_back(mean - previous);
      previous = mean;
    }
  }
  return Rms(differences) / std::sqrt(2.0);
}

class ImuSimulatorNoise : public ::testing::TestWithParam<double> {};

TEST_P(ImuSimulatorNoise, HasTheAllanDeviationOfTheDataSheetTimesTheRatio) {
  ImuSimulationOptions options;
  options.noise_ratio = GetParam();
  EXPECT_EQ(options.TrueNoise().gyroscope, GetParam() * options.noise.gyroscope);
  const auto samples = Simulator(options, 400.0).Samples(StandingStill(), {});
  for (const std::size_t cluster : {20U, 200U}) {
    const double tau = static_cast<double>(cluster) / options.rate;
    const auto expected = [tau](double white, double walk) {
      return std::hypot(white / std::sqrt(tau), walk * std::sqrt(tau / 3.0));
    };
    // 3 x 4000 and 3 x 400 differences, half of them independent: 1 % and 3 %.
    const double tolerance = cluster == 20 ? 0.04 : 0.12;
    const ImuNoise noise = options.TrueNoise();
    const double gyroscope = expected(noise.gyroscope, noise.gyroscope_walk);
    EXPECT_NEAR(AllanDeviation(samples, &ImuSample::gyroscope, cluster), gyroscope,
                tolerance * gyroscope);
    const double accelerometer = expected(noise.accelerometer, noise.accelerometer_walk);
    EXPECT_NEAR(AllanDeviation(samples, &ImuSample::accelerometer, cluster), accelerometer,
                tolerance * accelerometer);
  }
}

INSTANTIATE_TEST_SUITE_P(Ratios, ImuSimulatorNoise, ::testing::Values(1.0, 3.0));

TEST(ImuSimulator, BiasesStartAndWalkAsTheirSigmasSay) {
  const ImuSimulationOptions options;
  const CameraPath path = StandingStill();
  std::vector<double> gyroscope, accelerometer;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const ImuBias bias =
        Simulator(options, 0.1, seed).StateAt(path, {}, 0).bias;  // the first reading
    gyroscope.insert(gyroscope.end(), {bias[0], bias[1], bias[2]});
    accelerometer.insert(accelerometer.end(), {bias[3], bias[4], bias[5]});
  }
  // 1200 values: sigma / sqrt(2400) = 2 %.
  EXPECT_NEAR(Rms(gyroscope), options.gyroscope_bias, 0.08 * options.gyroscope_bias);
  EXPECT_NEAR(Rms(accelerometer), options.accelerometer_bias, 0.08 * options.accelerometer_bias);

  const ImuSimulator imu = Simulator(options, 500.0);
  gyroscope.clear();
  accelerometer.clear();
  for (int second = 0; second < 500; ++second) {
    const ImuBias step = imu.StateAt(path, {}, kBegin + FromSeconds(second + 1)).bias -
                         imu.StateAt(path, {}, kBegin + FromSeconds(second)).bias;
    gyroscope.insert(gyroscope.end(), {step[0], step[1], step[2]});
    accelerometer.insert(accelerometer.end(), {step[3], step[4], step[5]});
  }
  // 1500 steps of one second.
  const ImuNoise noise = options.TrueNoise();
  EXPECT_NEAR(Rms(gyroscope), noise.gyroscope_walk, 0.08 * noise.gyroscope_walk);
  EXPECT_NEAR(Rms(accelerometer), noise.accelerometer_walk, 0.08 * noise.accelerometer_walk);
}

TEST(ImuSimulator, ShakesWhereTheGroundIsRoughAndTheCameraMoves) {
  const ImuSimulationOptions options;
  const CameraPath path = Walk(2.0);
  const ImuSimulator imu = Simulator(options, 23.0);
  const auto calm = imu.Samples(path, {});
  const auto rough = imu.Samples(path, [](double s) { return s > 10.0 || s == 0.0 ? 1.0 : 0.0; });
  std::vector<double> x, z;
  int crossings = 0;
  for (std::size_t i = 0; i < calm.size(); ++i) {
    const Eigen::Vector3d shake = rough[i].accelerometer - calm[i].accelerometer;
    EXPECT_EQ(rough[i].gyroscope, calm[i].gyroscope);
    if (calm[i].stamp <= kBegin + FromSeconds(12.5)) {  // 10 s of the spline, or stationary
      EXPECT_EQ(shake.norm(), 0.0);
      continue;
    }
    if (!z.empty() && (shake.z() > 0.0) != (z.back() > 0.0)) ++crossings;
    x.push_back(shake.x());
    z.push_back(shake.z());
  }
  // 24 waves of equal amplitude: the RMS of their sum over 11 s is known to a few per cent.
  EXPECT_NEAR(Rms(x), options.vibration.x(), 0.05 * options.vibration.x());
  EXPECT_NEAR(Rms(z), options.vibration.z(), 0.05 * options.vibration.z());
  const double frequency =
      0.5 * crossings / (static_cast<double>(z.size()) / options.rate);  // [Hz] RMS of the band
  EXPECT_GT(frequency, options.vibration_low);
  EXPECT_LT(frequency, options.vibration_high);
}

TEST(ImuSimulator, ReadingsOfAShakenBodyAddUpToItsVelocity) {
  ImuSimulationOptions options;
  options.rate = 5000.0;  // high enough to keep vibration of 70 Hz
  options.noise_ratio = 1e-9;
  options.gyroscope_bias = options.accelerometer_bias = 0.0;
  const CameraPath path = Walk(1.0);  // a faster start causes more vibration
  const VibrationIntensity everywhere = [](double) { return 0.6; };
  const ImuSimulator imu = Simulator(options, 4.0);
  const ImuBuffer buffer = Buffer(imu.Samples(path, everywhere));
  double shaken = 0.0;
  for (double t = 0.01; t < 3.9; t += 0.1) {
    const TrueState from = imu.StateAt(path, everywhere, kBegin + FromSeconds(t));
    const TrueState to = imu.StateAt(path, everywhere, kBegin + FromSeconds(t + 0.0873));
    const auto interval = buffer.Between(from.stamp, to.stamp);
    ASSERT_TRUE(interval.has_value());
    const ImuState predicted =
        ImuPreintegration(interval->samples, from.bias).Predict(from.state, from.bias, kGravity_W);
    // The body rotates at 1 rad/s and starts within a second while it is shaken at 20 mm/s and at
    // least 20 Hz: some 20 mm/s^2 over a 125th of a second are neglected.
    EXPECT_LT((predicted.v_WB - to.state.v_WB).norm(), 1.6e-4);
    shaken = std::max(shaken, (to.state.v_WB - imu.StateAt(path, {}, to.stamp).state.v_WB).norm());
  }
  EXPECT_GT(shaken, 0.01);
}

TEST(ImuSimulator, SameSeedSameReadingsAnotherSeedOthers) {
  const auto one = Simulator({}, 2.0, 5).Samples(Walk(), {});
  const auto same = Simulator({}, 2.0, 5).Samples(Walk(), {});
  const auto other = Simulator({}, 2.0, 6).Samples(Walk(), {});
  ASSERT_EQ(one.size(), same.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].stamp, same[i].stamp);
    EXPECT_EQ(one[i].gyroscope, same[i].gyroscope);
    EXPECT_EQ(one[i].accelerometer, same[i].accelerometer);
    EXPECT_NE(one[i].gyroscope, other[i].gyroscope);
  }
}

TEST(ImuSimulator, RefusesOptionsOutOfRangeByName) {
  const auto message = [](const std::function<void(ImuSimulationOptions*)>& change) {
    ImuSimulationOptions options;
    change(&options);
    try {
      options.Validate();
    } catch (const InvalidArgument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message([](auto*) {}), "accepted");
  const auto expect_named = [&](const char* field, const auto& change) {
    EXPECT_NE(message(change).find(field), std::string::npos) << message(change);
  };
  expect_named("rate", [](auto* o) { o->rate = 0.0; });
  expect_named("noise_ratio", [](auto* o) { o->noise_ratio = 0.0; });
  expect_named("gyroscope_bias", [](auto* o) { o->gyroscope_bias = -1.0; });
  expect_named("accelerometer_bias", [](auto* o) { o->accelerometer_bias = NAN; });
  expect_named("time_offset", [](auto* o) { o->time_offset = 0.3; });
  expect_named("vibration", [](auto* o) { o->vibration.y() = -1.0; });
  expect_named("vibration_high", [](auto* o) { o->vibration_high = 120.0; });
  EXPECT_THROW(ImuSimulator({}, 1, kBegin, kBegin - 1), InvalidArgument);
}

}  // namespace
}  // namespace highwall::simulate::imu_simulator_test
