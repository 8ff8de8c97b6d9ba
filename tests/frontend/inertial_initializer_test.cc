#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "inertial/inertial_initializer.h"
#include "inertial_scene.h"

namespace highwall::inertial_initializer_test {
namespace {

using testing::AngleBetween;
using testing::InertialScene;
using testing::InertialSceneOptions;

constexpr double kDegree = M_PI / 180.0;
const ImuBias kBias = (ImuBias() << 0.008, -0.01, 0.005, 0.05, -0.08, 0.06).finished();
// A map whose z axis is far from up.
const Pose kTilted = Pose::FromTangent({3, -1, 2}, {0.5, -0.8, 1.3});

struct Trial {
  InitializationReport report;
  ImuState truth;
  ImuBias bias;
};

// Adds images at 10 Hz over `duration` [s], from 0.5 s on. change: of a reading, before it is
// added. overstated: factor by which the images' stated accuracy is too high. accelerometer_range:
// of the calibration.
Trial Initialize(
    const InertialSceneOptions& scene_options, double duration,
    const std::function<void(ImuSample&)>& change = [](ImuSample&) {},
    const InitializationCriteria& criteria = {}, double overstated = 1.0,
    double accelerometer_range = std::numeric_limits<double>::infinity()) {
  InertialScene scene(scene_options);
  ImuBuffer buffer;
  for (ImuSample reading : scene.Readings(0.0, 0.5 + duration)) {
    change(reading);
    buffer.Add(reading);
  }
  const ImuBias bias = scene.bias();
  for (ImuSample reading : scene.Readings(0.505 + duration, 0.7 + duration)) {
    change(reading);
    buffer.Add(reading);
  }
  ImuCalibration calibration = scene.calibration();
  calibration.accelerometer_range = accelerometer_range;
  InertialInitializer initializer(calibration, {}, true, std::nullopt, criteria);
  double t = 0.5;
  for (int k = 0; t <= 0.5 + duration + 1e-9; t = 0.5 + 0.1 * ++k) {
    VisualPose visual = scene.See(t);
    visual.sqrt_information *= overstated;
    initializer.Add(FromSeconds(t), visual);
  }
  return {initializer.Solve(buffer), scene.StateAt(0.5 + duration + scene_options.time_offset),
          bias};
}

TEST(InertialInitializer, FindsGravityBiasesVelocityAndOffsetInMotion) {
  for (const double time_offset : {0.0, 0.02, -0.03}) {
    SCOPED_TRACE(time_offset);
    const InertialSceneOptions scene{.bias = kBias, .time_offset = time_offset, .T_WN = kTilted};
    const Trial run = Initialize(scene, 4.0);
    ASSERT_EQ(run.report.status, InitializationStatus::kReady) << run.report.error;
    ASSERT_TRUE(run.report.estimate);
    const InertialPrior& prior = *run.report.estimate;
    EXPECT_LT(AngleBetween(prior.gravity_W.vector(), kTilted.q() * kGravity), 0.3 * kDegree);
    EXPECT_NEAR(prior.time_offset, time_offset, 1e-3);
    EXPECT_NEAR(prior.time_offset, time_offset, 4.0 * prior.time_offset_sigma());
    const auto error = testing::EstimateError(run.truth, run.bias, prior.estimate);
    const auto sigma = prior.estimate.covariance.diagonal().cwiseSqrt();
    for (int i = 3; i < 15; ++i) EXPECT_LT(std::abs(error(i)), 3.5 * sigma(i)) << i;
    // The estimate must be more accurate than the prior.
    EXPECT_LT(sigma.segment<3>(9).maxCoeff(), 0.002);
    EXPECT_LT(sigma.tail<3>().maxCoeff(), 0.05);
    EXPECT_LT(sigma.segment<3>(6).maxCoeff(), 0.02);
    EXPECT_NEAR(run.report.gravity_norm, 9.81, 0.1);
    EXPECT_NEAR(run.report.duration, 4.0, 1e-9);
    // 41 images, 6 rows each, and 15 an interval: the mean of some 240 degrees of freedom.
    EXPECT_NEAR(run.report.error, 1.0, 0.35);
  }
}

TEST(InertialInitializer, FindsTheDirectionOfGravityAtRest) {
  // At rest a tilt is indistinguishable from a bias of the accelerometer, so the latter has to be
  // small.
  const ImuBias bias = (ImuBias() << 0.008, -0.01, 0.005, 0.01, -0.02, 0.03).finished();
  const InertialSceneOptions scene{.motion = 0.0, .bias = bias, .T_WN = kTilted};
  const Trial run = Initialize(scene, 2.0);
  ASSERT_EQ(run.report.status, InitializationStatus::kReady) << run.report.error;
  const InertialPrior& prior = *run.report.estimate;
  EXPECT_LT(AngleBetween(prior.gravity_W.vector(), kTilted.q() * kGravity), 0.3 * kDegree);
  EXPECT_LT(prior.estimate.state.v_WB.norm(), 0.01);
  const auto error = testing::EstimateError(run.truth, run.bias, prior.estimate);
  const auto sigma = prior.estimate.covariance.diagonal().cwiseSqrt();
  for (int i = 3; i < 15; ++i) EXPECT_LT(std::abs(error(i)), 3.5 * sigma(i)) << i;
  EXPECT_LT(sigma.segment<3>(9).maxCoeff(), 0.002);
  EXPECT_GT(prior.gravity_sigma(), 0.1 / 9.81 * 0.8) << "as the bias is unknown, so is the tilt";
}

TEST(InertialInitializer, ErrorsAreConsistentWithTheirCovariance) {
  // Normalised estimation error squared of velocity and biases, 9 degrees of freedom: over N runs
  // its mean is 9 +- sqrt(18 / N).
  constexpr int kRuns = 20;
  double sum = 0.0;
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;
  const InertialInitializerOptions options;
  for (unsigned run = 0; run < kRuns; ++run) {
    InertialSceneOptions scene{.T_WN = kTilted, .seed = run + 1};
    // The biases are drawn from the initializer's prior.
    for (int i = 0; i < 6; ++i) {
      scene.bias(i) =
          normal(rng) * (i < 3 ? options.gyroscope_bias_sigma : options.accelerometer_bias_sigma);
    }
    const Trial result = Initialize(scene, 1.2);
    ASSERT_TRUE(result.report.estimate);
    const InertialEstimate& estimate = result.report.estimate->estimate;
    const Eigen::Matrix<double, 9, 1> error =
        testing::EstimateError(result.truth, result.bias, estimate).tail<9>();
    sum += error.dot(estimate.covariance.bottomRightCorner<9, 9>().ldlt().solve(error));
  }
  EXPECT_NEAR(sum / kRuns, 9.0, 4.0 * std::sqrt(18.0 / kRuns));
}

TEST(InertialInitializer, NeedsMoreTimeWhereTheNoiseOfImagesIsUnderstated) {
  const InertialSceneOptions scene{.bias = kBias, .T_WN = kTilted};
  const InitializationCriteria criteria{.max_gravity_sigma = 0.1};  // must not affect the wait
  constexpr double kOverstated = 4.0;
  const auto none = [](ImuSample&) {};
  const InitializationReport early = Initialize(scene, 1.5, none, criteria, kOverstated).report;
  EXPECT_EQ(early.status, InitializationStatus::kUncertain);
  EXPECT_GT(early.error, 4.0);
  EXPECT_EQ(Initialize(scene, 1.5, none, criteria).report.status, InitializationStatus::kReady);
  const InitializationReport late = Initialize(scene, 5.0, none, criteria, kOverstated).report;
  EXPECT_EQ(late.status, InitializationStatus::kReady) << late.error;
  EXPECT_GT(late.error, 4.0);
}

TEST(InertialInitializer, IsTooShortAtFirst) {
  EXPECT_EQ(Initialize({}, 0.8).report.status, InitializationStatus::kTooShort);
  EXPECT_NE(Initialize({}, 1.2).report.status, InitializationStatus::kTooShort);
  const InertialInitializer empty({}, {}, true);
  EXPECT_EQ(empty.Solve(ImuBuffer()).status, InitializationStatus::kTooShort);
}

TEST(InertialInitializer, SaysWhereReadingsAreMissing) {
  InertialScene scene;
  InertialInitializer initializer(scene.calibration(), {}, true);
  for (int k = 0; k <= 20; ++k)
    initializer.Add(FromSeconds(0.5 + 0.1 * k), scene.See(0.5 + 0.1 * k));
  EXPECT_EQ(initializer.Solve(ImuBuffer()).status, InitializationStatus::kNoImu);
  ImuBuffer early, late, gap, long_ago;
  for (const ImuSample& reading : scene.Readings(0.0, 3.0)) {
    const double t = ToSeconds(reading.stamp);
    if (t < 2.0) early.Add(reading);
    if (t > 2.0) late.Add(reading);
    if (t < 1.8 || t > 2.0) gap.Add(reading);
    if (t < 0.7 || t > 0.9) long_ago.Add(reading);
  }
  EXPECT_EQ(initializer.Solve(early).status, InitializationStatus::kNoImu);
  EXPECT_EQ(initializer.Solve(late).status, InitializationStatus::kNoImu);
  EXPECT_EQ(initializer.Solve(gap).status, InitializationStatus::kNoImu);
  // The readings after the gap are sufficient.
  const InitializationReport report = initializer.Solve(long_ago);
  EXPECT_NE(report.status, InitializationStatus::kNoImu);
  EXPECT_TRUE(report.estimate);
  EXPECT_NEAR(report.duration, 1.6, 0.11);
}

TEST(InertialInitializer, IsUncertainAsLongAsGravityIs) {
  const InitializationCriteria criteria{.max_gravity_sigma = 1e-4};
  const Trial run = Initialize(
      {}, 1.5, [](ImuSample&) {}, criteria);
  EXPECT_EQ(run.report.status, InitializationStatus::kUncertain);
  EXPECT_GT(run.report.gravity_sigma, 1e-4);
  EXPECT_TRUE(run.report.estimate);
}

TEST(InertialInitializer, ReadingsInGHaveAWrongGravity) {
  for (const double motion : {0.0, 1.0}) {
    const Trial run = Initialize({.motion = motion}, 2.0,
                                 [](ImuSample& reading) { reading.accelerometer /= 9.80665; });
    EXPECT_EQ(run.report.status, InitializationStatus::kWrongGravity) << motion;
    EXPECT_LT(run.report.gravity_norm, 9.81 * 0.9) << motion;
    EXPECT_FALSE(run.report.estimate);
  }
}

TEST(InertialInitializer, ANegatedAccelerometerContradictsTheImagesInMotion) {
  const Trial run = Initialize({}, 4.0, [](ImuSample& reading) { reading.accelerometer *= -1.0; });
  EXPECT_TRUE(run.report.status == InitializationStatus::kInconsistent ||
              run.report.status == InitializationStatus::kWrongGravity)
      << ToString(run.report.status);
}

TEST(InertialInitializer, DegreesASecondContradictTheImages) {
  const Trial run =
      Initialize({}, 4.0, [](ImuSample& reading) { reading.gyroscope *= 180.0 / M_PI; });
  EXPECT_TRUE(run.report.status == InitializationStatus::kInconsistent ||
              run.report.status == InitializationStatus::kWrongGravity)
      << ToString(run.report.status);
}

TEST(InertialInitializer, GivesReadingsAtTheLimitOfAKnownRangeLittleWeight) {
  constexpr double kRange = 9.81;  // [m/s^2] gravity alone: the motion exceeds it at times
  const auto ends = [=](ImuSample& reading) {
    reading.accelerometer = reading.accelerometer.cwiseMax(-kRange).cwiseMin(kRange);
  };
  const InertialSceneOptions scene{.bias = kBias, .T_WN = kTilted};
  const Trial without_range = Initialize(scene, 4.0, ends);
  EXPECT_EQ(without_range.report.status, InitializationStatus::kInconsistent);
  const Trial with_range = Initialize(scene, 4.0, ends, {}, 1.0, kRange);
  ASSERT_EQ(with_range.report.status, InitializationStatus::kReady) << with_range.report.error;
  const InertialPrior& prior = *with_range.report.estimate;
  EXPECT_LT(AngleBetween(prior.gravity_W.vector(), kTilted.q() * kGravity), 0.5 * kDegree);
  const auto error = testing::EstimateError(with_range.truth, with_range.bias, prior.estimate);
  const auto sigma = prior.estimate.covariance.diagonal().cwiseSqrt();
  for (int i = 3; i < 15; ++i) EXPECT_LT(std::abs(error(i)), 3.5 * sigma(i)) << i;
}

TEST(InertialInitializer, ImagesThatLeaveADirectionOpenAreNoFailure) {
  // A camera in front of a wall without texture along one axis, and one that sees nothing at all.
  for (const bool blind : {false, true}) {
    InertialScene scene;
    ImuBuffer buffer;
    for (const ImuSample& reading : scene.Readings(0.0, 3.0)) buffer.Add(reading);
    InertialInitializer initializer(scene.calibration(), {}, true);
    for (int k = 0; k <= 20; ++k) {
      VisualPose visual = scene.See(0.5 + 0.1 * k);
      visual.sqrt_information.row(0).setZero();
      if (blind) visual.sqrt_information.setZero();
      initializer.Add(FromSeconds(0.5 + 0.1 * k), visual);
    }
    InitializationReport report;
    ASSERT_NO_THROW(report = initializer.Solve(buffer)) << blind;
    EXPECT_EQ(report.status, InitializationStatus::kUncertain) << blind;
  }
}

TEST(InertialInitializer, ErrorIsOneOnAverageWhateverTheImagesLeaveOpen) {
  for (const int open : {0, 1, 3}) {
    constexpr int kRuns = 20, kImages = 31;
    double sum = 0.0;
    for (unsigned run = 0; run < kRuns; ++run) {
      // The biases are within their prior, or nearly so.
      InertialScene scene({.seed = run + 1});
      ImuBuffer buffer;
      for (const ImuSample& reading : scene.Readings(0.0, 4.0)) buffer.Add(reading);
      InertialInitializer initializer(scene.calibration(), {}, true);
      for (int k = 0; k < kImages; ++k) {
        VisualPose visual = scene.See(0.5 + 0.1 * k);
        visual.sqrt_information.topRows(open).setZero();
        initializer.Add(FromSeconds(0.5 + 0.1 * k), visual);
      }
      sum += initializer.Solve(buffer).error;
    }
    // Chi-squared of some 6 - open rows an image: 1 +- sqrt(2 / rows). Biases at zero, where the
    // prior allows for seven values, and unconstrained unknowns, when three positions are
    // unobservable, account for up to ten degrees of freedom of 80 to 175.
    const double rows = (6.0 - open) * kImages;
    EXPECT_NEAR(sum / kRuns, 1.0, 10.0 / rows + 4.0 * std::sqrt(2.0 / (rows * kRuns))) << open;
  }
}

TEST(InertialInitializer, DropsOldReadingsAndAllOfThemOnRequest) {
  InertialScene scene;
  ImuBuffer buffer;
  for (const ImuSample& reading : scene.Readings(0.0, 12.0)) buffer.Add(reading);
  InertialInitializer initializer(scene.calibration(), {}, true, std::nullopt,
                                  {.max_duration = 2.0});
  for (int k = 0; k <= 300; ++k) {
    const double t = 0.5 + k / 30.0;
    initializer.Add(FromSeconds(t), scene.See(t));
  }
  EXPECT_NEAR(initializer.Solve(buffer).duration, 2.0, 0.1);
  initializer.Clear();
  EXPECT_EQ(initializer.Solve(buffer).status, InitializationStatus::kTooShort);
}

TEST(InertialInitializer, AKnownOffsetIsKept) {
  InertialScene scene({.time_offset = 0.01});
  ImuBuffer buffer;
  for (const ImuSample& reading : scene.Readings(0.0, 4.0)) buffer.Add(reading);
  ImuCalibration calibration = scene.calibration();
  calibration.time_offset = 0.01;
  InertialInitializer initializer(calibration, {}, false);
  for (int k = 0; k <= 30; ++k)
    initializer.Add(FromSeconds(0.5 + 0.1 * k), scene.See(0.5 + 0.1 * k));
  const InitializationReport report = initializer.Solve(buffer);
  ASSERT_EQ(report.status, InitializationStatus::kReady);
  EXPECT_EQ(report.estimate->time_offset, 0.01);
  EXPECT_NEAR(report.error, 1.0, 0.4);
}

TEST(RateAt, IsTheMeanOfTenMillisecondsAround) {
  ImuBuffer buffer;
  EXPECT_EQ(RateAt(buffer, 0, ImuBias::Zero()).norm(), 0.0);
  const SinusoidalMotion motion;
  for (const ImuSample& sample : motion.Samples(200.0, 1.0)) buffer.Add(sample);
  const Stamp stamp = FromSeconds(0.5);
  // The mean of a smooth rate is off by its second derivative times (10 ms)^2 / 4.
  EXPECT_LT((RateAt(buffer, stamp, ImuBias::Zero()) - motion.SampleAt(stamp).gyroscope).norm(),
            2e-4);
  const ImuBias bias = (ImuBias() << 0.1, 0.2, 0.3, 0, 0, 0).finished();
  EXPECT_TRUE(RateAt(buffer, stamp, bias)
                  .isApprox(RateAt(buffer, stamp, ImuBias::Zero()) - bias.head<3>(), 1e-14));
  EXPECT_EQ(RateAt(buffer, FromSeconds(2.0), bias).norm(), 0.0) << "beyond the readings";
}

TEST(InitializationStatus, HasNames) {
  EXPECT_STREQ(ToString(InitializationStatus::kReady), "ready");
  EXPECT_STREQ(ToString(InitializationStatus::kWrongGravity), "wrong gravity");
}

}  // namespace
}  // namespace highwall::inertial_initializer_test
