#include <highwall/frontend/calibration/camera_imu_calibration.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

#include "calibration/axes_alignment.h"
#include "support/imu_scene.h"

namespace highwall::camera_imu_calibration_test {
namespace {

constexpr double kHertz = 200.0, kFps = 20.0;

struct Truth {
  Pose T_BC{so3::Exp({0.4, -1.3, 2.0}), {0.08, -0.03, 0.12}};
  double time_offset = 0.017, depth_scale = 0.97;
  Eigen::Vector3d gyroscope_bias{0.02, -0.01, 0.03}, accelerometer_bias{0.1, -0.05, 0.08};
  double duration = 30.0;        // [s]
  bool turns = true;             // otherwise the camera keeps its orientation
  double position_noise = 1e-3;  // [m] of a camera pose
  double rotation_noise = 1e-3;  // [rad]
};

const ImuNoise kNoise{
    .gyroscope = 2e-4, .accelerometer = 2e-3, .gyroscope_walk = 1e-5, .accelerometer_walk = 1e-4};

struct Recording {
  Trajectory camera;
  std::vector<ImuSample> readings;
};

Recording Record(const Truth& truth, unsigned seed) {
  const SinusoidalMotion motion(truth.turns ? 1.5 : 0.0);
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    const double x = normal(rng), y = normal(rng), z = normal(rng);
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
  };
  Recording recording;
  const double root = std::sqrt(kHertz);
  Eigen::Vector3d walk_g = truth.gyroscope_bias, walk_a = truth.accelerometer_bias;
  for (ImuSample sample : motion.Samples(kHertz, truth.duration)) {
    sample.gyroscope += walk_g + noise(kNoise.gyroscope * root);
    sample.accelerometer += walk_a + noise(kNoise.accelerometer * root);
    walk_g += noise(kNoise.gyroscope_walk / root);
    walk_a += noise(kNoise.accelerometer_walk / root);
    recording.readings.push_back(sample);
  }
  // The map begins at the camera: it has a world of its own, whose scale is that of its depth.
  const Pose T_MW = Pose::FromTangent({0.3, -1.0, 0.2}, {0.5, -0.2, 1.0});
  for (double t = 0.3; t < truth.duration - 0.3; t += 1.0 / kFps) {
    const Pose T_MC = T_MW * motion.StateAt(t).T_WB * truth.T_BC;
    recording.camera.push_back({FromSeconds(t - truth.time_offset),
                                Pose(T_MC.q() * so3::Exp(noise(truth.rotation_noise)),
                                     T_MC.p() / truth.depth_scale + noise(truth.position_noise))});
  }
  return recording;
}

CameraImuCalibration Calibrate(const Recording& recording, bool with_scale = true) {
  return *CalibrateCameraImu(recording.camera, recording.readings,
                             {.noise = kNoise, .estimate_depth_scale = with_scale});
}

// Returns the reason why there is no calibration; empty if there is one.
std::string FaultOf(const Recording& recording) {
  std::string reason;
  const bool found =
      CalibrateCameraImu(recording.camera, recording.readings, {.noise = kNoise}, &reason)
          .has_value();
  EXPECT_EQ(found, reason.empty()) << reason;
  return reason;
}

// Returns the errors in standard deviations: of each of the six of T_BC, of t_d and of s.
Eigen::Matrix<double, 8, 1> NormalisedErrors(const CameraImuCalibration& found,
                                             const Truth& truth) {
  Eigen::Matrix<double, 8, 1> e;
  e << (found.T_BC.p() - truth.T_BC.p()).cwiseQuotient(found.lever_arm_sigma),
      so3::Log(truth.T_BC.q().conjugate() * found.T_BC.q()).cwiseQuotient(found.rotation_sigma),
      (found.time_offset - truth.time_offset) / found.time_offset_sigma,
      (found.depth_scale - truth.depth_scale) / found.depth_scale_sigma;
  return e;
}

TEST(AlignAxes, FindsTheAxesTheOffsetAndTheBiasWithoutAGuess) {
  const Truth truth;
  const Recording recording = Record(truth, 1);
  ImuBuffer buffer({.max_step = 0.1, .horizon = 1e6});
  for (const ImuSample& sample : recording.readings) buffer.Add(sample);
  const AxesAlignment axes = *AlignAxes(recording.camera, buffer, 0.2, 0.5);
  EXPECT_LT(so3::Log(truth.T_BC.q().conjugate() * axes.q_BC).norm(), 0.01);
  EXPECT_NEAR(axes.time_offset, truth.time_offset, 2e-3);
  EXPECT_LT((axes.gyroscope_bias - truth.gyroscope_bias).norm(), 5e-3);
}

TEST(CameraImuCalibration, FindsTheCameraOnTheBodyTheClocksAndTheMetre) {
  const Truth truth;
  const CameraImuCalibration found = Calibrate(Record(truth, 2));
  const Pose error = truth.T_BC.Inverse() * found.T_BC;
  // The accuracy required of a minute of real images is reached here with half of that.
  EXPECT_LT(error.p().norm(), 2e-3);
  EXPECT_LT(so3::Log(error.q()).norm(), 0.1 * M_PI / 180.0);
  EXPECT_NEAR(found.time_offset, truth.time_offset, 2e-4);
  EXPECT_NEAR(found.depth_scale, truth.depth_scale, 3e-3);
  EXPECT_LT((found.bias.head<3>() - truth.gyroscope_bias).norm(), 1e-3);
  EXPECT_LT((found.bias.tail<3>() - truth.accelerometer_bias).norm(), 2e-2);
  EXPECT_NEAR(found.position_error, truth.position_noise, 3e-4);
  EXPECT_NEAR(found.rotation_error, truth.rotation_noise, 3e-4);
  EXPECT_TRUE(found.advice.empty()) << found.advice.front();
}

TEST(CameraImuCalibration, ItsErrorsAreThoseThatItStates) {
  constexpr int kSeeds = 30;
  double squares = 0.0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    Truth truth;
    truth.duration = 10.0;
    const auto found = Calibrate(Record(truth, 100 + seed));
    squares += NormalisedErrors(found, truth).squaredNorm() / 8.0;
  }
  // 240 numbers, correlated within a seed, have a standard error of about 0.14. The inflation for
  // systematic errors, of which there are none here, reduces the sum.
  EXPECT_GT(squares / kSeeds, 0.5);
  EXPECT_LT(squares / kSeeds, 1.4);
}

TEST(CameraImuCalibration, KeepsTheScaleOfTheDepthOnRequest) {
  Truth truth;
  truth.depth_scale = 1.0;
  const auto found = Calibrate(Record(truth, 3), false);
  EXPECT_EQ(found.depth_scale, 1.0);
  EXPECT_EQ(found.depth_scale_sigma, 0.0);
  EXPECT_LT((found.T_BC.p() - truth.T_BC.p()).norm(), 2e-3);
}

TEST(CameraImuCalibration, GapsInTheTrackAddNoConstraint) {
  const Truth truth;
  Recording recording = Record(truth, 4);
  recording.camera.erase(recording.camera.begin() + 200, recording.camera.begin() + 260);  // 3 s
  recording.readings.erase(recording.readings.begin() + 1'000, recording.readings.begin() + 1'100);
  const auto found = Calibrate(recording);
  EXPECT_LT((found.T_BC.p() - truth.T_BC.p()).norm(), 2.5e-3);
  EXPECT_NEAR(found.time_offset, truth.time_offset, 3e-4);
}

TEST(CameraImuCalibration, AFewWrongPosesChangeLittle) {
  const Truth truth;
  Recording recording = Record(truth, 5);
  for (std::size_t i = 50; i < recording.camera.size(); i += 60) {
    Pose& pose = recording.camera[i].pose;
    pose = Pose(pose.q() * so3::Exp({0.05, 0.0, 0.0}), pose.p() + Eigen::Vector3d(0.1, 0.0, 0.05));
  }
  const auto found = Calibrate(recording);
  EXPECT_LT((found.T_BC.p() - truth.T_BC.p()).norm(), 6e-3);
  EXPECT_LT(so3::Log(truth.T_BC.q().conjugate() * found.T_BC.q()).norm(), 5e-3);
}

TEST(CameraImuCalibration, NamesTheMissingRotations) {
  // The body rotates about one of its axes only, as a robot on a floor does.
  const Truth truth;
  Recording recording;
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  const auto yaw = [](double t) { return 0.8 * std::sin(1.7 * t); };
  for (int i = 0; i <= 6'000; ++i) {
    const double t = i / kHertz, w = 0.8 * 1.7 * std::cos(1.7 * t);
    ImuSample sample{FromSeconds(t), {0.0, 0.0, w}, {0.0, 0.0, 9.81}};
    for (int k = 0; k < 3; ++k) {
      sample.gyroscope[k] += 3e-3 * normal(rng);
      sample.accelerometer[k] += 3e-2 * normal(rng);
    }
    recording.readings.push_back(sample);
  }
  for (double t = 0.5; t < 29.5; t += 1.0 / kFps) {
    const Pose T_WB(so3::Exp({0, 0, yaw(t)}), Eigen::Vector3d::Zero());
    recording.camera.push_back({FromSeconds(t), T_WB * truth.T_BC});
  }
  const std::string fault = FaultOf(recording);
  EXPECT_NE(fault.find("about all three"), std::string::npos)
      << "one axis does not tell the others apart: " << fault;
}

// Returns the recording of a body that rotates about all of its axes but sways by `sway` [m] only.
Recording Turn(const Truth& truth, double sway, unsigned seed) {
  Recording recording;
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    const double x = normal(rng), y = normal(rng), z = normal(rng);
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
  };
  const SinusoidalMotion motion(1.5);
  // The position is that of the motion, scaled down.
  const double share = sway / 1.2;
  for (ImuSample sample : motion.Samples(kHertz, 30.0)) {
    const Eigen::Quaterniond q = motion.StateAt(ToSeconds(sample.stamp)).T_WB.q();
    const Eigen::Vector3d a_W = q * sample.accelerometer + kGravity;
    sample.accelerometer = q.conjugate() * (share * a_W - kGravity) + noise(0.03);
    sample.gyroscope += noise(0.003);
    recording.readings.push_back(sample);
  }
  for (double t = 0.3; t < 29.7; t += 1.0 / kFps) {
    const Pose T_WB = motion.StateAt(t).T_WB;
    const Pose T_WC = Pose(T_WB.q(), share * T_WB.p()) * truth.T_BC;
    recording.camera.push_back(
        {FromSeconds(t), Pose(T_WC.q() * so3::Exp(noise(2e-3)), T_WC.p() + noise(3e-3))});
  }
  return recording;
}

// Noise of the poses must not draw the scale to 0, where all of them would agree.
TEST(CameraImuCalibration, AMotionTooSmallForTheScaleLeavesItOpenOrRight) {
  const Truth truth;
  for (const double sway : {0.0, 0.02, 0.05}) {
    SCOPED_TRACE(sway);
    const auto found = Calibrate(Turn(truth, sway, 21));
    EXPECT_LT(std::abs(found.depth_scale - 1.0), 3.0 * found.depth_scale_sigma);
    const bool is_advised = std::ranges::any_of(found.advice, [](const std::string& advice) {
      return advice.starts_with("the depth scale is not known to a percent");
    });
    EXPECT_EQ(is_advised, found.depth_scale_sigma > 0.01);
    if (sway == 0.0) {
      EXPECT_TRUE(is_advised) << found.depth_scale_sigma;
    }
    EXPECT_LT((found.T_BC.p() - truth.T_BC.p()).norm(), 0.02);
  }
}

TEST(CameraImuCalibration, RefusesAnAccelerometerAndACameraThatContradictEachOther) {
  const Truth truth;
  Recording reversed = Record(truth, 22);
  for (ImuSample& sample : reversed.readings) sample.accelerometer *= -1.0;
  std::string reason;
  EXPECT_FALSE(CalibrateCameraImu(reversed.camera, reversed.readings, {.noise = kNoise}, &reason));
  EXPECT_NE(reason.find("not that of the accelerometer: its sign?"), std::string::npos) << reason;
  Recording other = Record(truth, 23);
  std::ranges::reverse(other.camera);
  for (std::size_t i = 0; i < other.camera.size() / 2; ++i) {
    std::swap(other.camera[i].stamp, other.camera[other.camera.size() - 1 - i].stamp);
  }
  EXPECT_FALSE(CalibrateCameraImu(other.camera, other.readings, {.noise = kNoise}, &reason))
      << "the motion backwards";
  EXPECT_NE(reason, "");
}

TEST(CameraImuCalibration, GivesReadingsAtTheLimitOfAKnownRangeLittleWeight) {
  const Truth truth;
  Recording recording = Record(truth, 25);
  constexpr double kGyroscope = 2.0, kAccelerometer = 11.0;  // [rad/s], [m/s^2]
  int ended = 0;
  for (ImuSample& sample : recording.readings) {
    ended += sample.gyroscope.cwiseAbs().maxCoeff() > kGyroscope ||
             sample.accelerometer.cwiseAbs().maxCoeff() > kAccelerometer;
    sample.gyroscope = sample.gyroscope.cwiseMax(-kGyroscope).cwiseMin(kGyroscope);
    sample.accelerometer = sample.accelerometer.cwiseMax(-kAccelerometer).cwiseMin(kAccelerometer);
  }
  EXPECT_GT(ended, 300) << "of 6000";
  const CameraImuCalibration with_range = *CalibrateCameraImu(
      recording.camera, recording.readings,
      {.noise = kNoise, .gyroscope_range = kGyroscope, .accelerometer_range = kAccelerometer});
  // As in FindsTheCameraOnTheBodyTheClocksAndTheMetre, with fewer readings: the fastest are
  // missing.
  EXPECT_LT((with_range.T_BC.p() - truth.T_BC.p()).norm(), 5e-3);
  EXPECT_LT((truth.T_BC.Inverse() * with_range.T_BC).Angle(), 0.1 * M_PI / 180.0);
  EXPECT_NEAR(with_range.time_offset, truth.time_offset, 3e-4);
  EXPECT_NEAR(with_range.depth_scale, truth.depth_scale, 5e-3);
  std::string reason;
  const auto without_range =
      CalibrateCameraImu(recording.camera, recording.readings, {.noise = kNoise}, &reason);
  if (without_range) {
    EXPECT_GT((without_range->T_BC.p() - truth.T_BC.p()).norm(), 1e-2);
  } else {
    EXPECT_NE(reason.find("range"), std::string::npos) << reason;
  }
}

TEST(CameraImuCalibration, PosesWithoutReadingsTakeNoPart) {
  const Truth truth;
  Recording recording = Record(truth, 24);
  recording.readings.resize(3'000);  // half of the time
  const auto found = Calibrate(recording);
  EXPECT_NEAR(found.poses, 15.0 / 0.1, 6.0);
  EXPECT_LT((found.bias.head<3>() - truth.gyroscope_bias).norm(), 2e-3);
  recording.readings.resize(300);  // 1.5 s
  EXPECT_NE(FaultOf(recording), "");
}

TEST(CameraImuCalibration, DataThatDoNotSufficeGiveNoneAndAReason) {
  const Truth truth;
  const Recording recording = Record(truth, 8);
  EXPECT_FALSE(CalibrateCameraImu({}, recording.readings));
  EXPECT_FALSE(CalibrateCameraImu(recording.camera, {}));
  Recording later = recording;
  for (ImuSample& sample : later.readings) sample.stamp += FromSeconds(100.0);
  EXPECT_NE(FaultOf(later), "");
  Recording degrees = recording;
  for (ImuSample& sample : degrees.readings) sample.gyroscope *= 180.0 / M_PI;
  EXPECT_NE(FaultOf(degrees), "");
  Truth still = truth;
  still.turns = false;
  EXPECT_NE(FaultOf(Record(still, 9)), "");
}

TEST(CameraImuCalibration, RefusesBadOptions) {
  const Recording recording = Record(Truth(), 8);
  EXPECT_THROW(CalibrateCameraImu(recording.camera, recording.readings, {.interval = 0.0}),
               InvalidArgument);
}

}  // namespace
}  // namespace highwall::camera_imu_calibration_test
