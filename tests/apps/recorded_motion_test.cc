// Fits a motion to captured poses and readings, and simulates a room recorded along it.
#include "simulate/motion/recorded_motion.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

#include "simulate/scenes/recorded_room.h"
#include "support/imu_scene.h"

namespace highwall::simulate::recorded_motion_test {
namespace {

constexpr double kHertz = 200.0, kDuration = 12.0;
const ImuNoise kNoise{
    .gyroscope = 2e-4, .accelerometer = 2e-3, .gyroscope_walk = 1e-6, .accelerometer_walk = 1e-5};
constexpr double kTilt = 0.02;  // [rad] of the captured world

struct Captured {
  Trajectory poses;
  std::vector<ImuSample> readings;
};

Pose TiltedWorld() {
  return Pose::FromTangent({0.5, -0.3, 0.2}, {kTilt, 0.0, 0.0});
}

// Captures a motion with noise on all measurements, and a bias.
Captured Capture(unsigned seed) {
  const SinusoidalMotion motion;
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    const double x = normal(rng), y = normal(rng), z = normal(rng);
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
  };
  Captured captured;
  for (ImuSample sample : motion.Samples(kHertz, kDuration)) {
    const Pose T_WB = TiltedWorld() * motion.StateAt(ToSeconds(sample.stamp)).T_WB;
    captured.poses.push_back(
        {sample.stamp, Pose(T_WB.q() * so3::Exp(noise(2e-3)), T_WB.p() + noise(1e-3))});
    sample.gyroscope += Eigen::Vector3d(0.02, -0.01, 0.08) + noise(2e-4 * std::sqrt(kHertz));
    sample.accelerometer += Eigen::Vector3d(0.05, 0.1, -0.03) + noise(2e-3 * std::sqrt(kHertz));
    captured.readings.push_back(sample);
  }
  return captured;
}

RecordedMotion Fit(const Captured& captured) {
  return FitRecordedMotion(captured.poses, captured.readings,
                           {.noise = kNoise, .orientation_sigma = 2e-3, .error_lasts = 0.0125});
}

TEST(RecordedMotion, IsNearerToTheTruthThanTheCapturedMotion) {
  const Captured captured = Capture(1);
  const RecordedMotion motion = Fit(captured);
  ASSERT_GT(motion.states.size(), 470U);
  // Gravity-aligned: the captured world is rotated so that gravity is along -z; yaw and position
  // are free.
  const SinusoidalMotion truth;
  const Pose T_UT = motion.states[200].T_WB *
                    truth.StateAt(ToSeconds(motion.begin) + 200 * motion.interval).T_WB.Inverse();
  EXPECT_LT((T_UT.q() * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitZ()).norm(), 2e-3);
  double worst_position = 0.0, worst_angle = 0.0;
  for (std::size_t i = 40; i + 40 < motion.states.size(); ++i) {
    const double t = ToSeconds(motion.begin) + static_cast<double>(i) * motion.interval;
    const Pose error = (T_UT * truth.StateAt(t).T_WB).Inverse() * motion.states[i].T_WB;
    worst_position = std::max(worst_position, error.p().norm());
    worst_angle = std::max(worst_angle, so3::Log(error.q()).norm());
  }
  // One captured pose has an error of 1.7 mm and 3.5 mrad.
  EXPECT_LT(worst_position, 2e-3);
  EXPECT_LT(worst_angle, 1.5e-3);
}

TEST(RecordedMotion, FindsTheBiasesAndSaysHowWellAllAgrees) {
  const RecordedMotion motion = Fit(Capture(2));
  const ImuBias& bias = motion.biases[motion.biases.size() / 2];
  EXPECT_LT((bias.head<3>() - Eigen::Vector3d(0.02, -0.01, 0.08)).norm(), 1e-3);
  EXPECT_LT((bias.tail<3>() - Eigen::Vector3d(0.05, 0.1, -0.03)).norm(), 2e-2);
  // The median of a norm of three is 1.54 sigma.
  EXPECT_NEAR(motion.consistency.position, 1.54e-3, 2e-4);
  EXPECT_NEAR(motion.consistency.orientation, 1.54 * 2e-3, 4e-4);
  EXPECT_NEAR(motion.consistency.gyroscope, 1.54 * 2e-4 * std::sqrt(kHertz), 5e-4);
  EXPECT_NEAR(motion.consistency.accelerometer, 1.54 * 2e-3 * std::sqrt(kHertz), 5e-3);
}

TEST(RecordedMotion, APathGoesThroughItsStatesWithTheirVelocities) {
  const RecordedMotion motion = Fit(Capture(3));
  const Pose T_BC(so3::Exp({0.3, -0.2, 0.5}), {0.1, 0.02, -0.05});
  const SplineTrajectory path = motion.PathOf(T_BC, 30);
  for (std::size_t i = 0; i < 300; i += 7) {
    const double t = static_cast<double>(i) * motion.interval;
    const ImuState& state = motion.states[i + 30];
    const Pose error = (state.T_WB * T_BC).Inverse() * path.T_WC(t);
    EXPECT_LT(error.p().norm(), 1e-5);
    EXPECT_LT(so3::Log(error.q()).norm(), 1e-5);
    const CameraMotion at = path.MotionAt(t);
    const Eigen::Vector3d lever = at.T_WC.q() * T_BC.Inverse().p();
    const Eigen::Vector3d v_WB = at.v_WC + (at.T_WC.q() * at.w_C).cross(lever);
    EXPECT_LT((v_WB - state.v_WB).norm(), 5e-3);
  }
}

TEST(RecordedMotion, HolesInTheCaptureAreBridgedByTheReadings) {
  Captured captured = Capture(4);
  captured.poses.erase(captured.poses.begin() + 1'000, captured.poses.begin() + 1'100);
  const RecordedMotion motion = Fit(captured), whole = Fit(Capture(4));
  ASSERT_EQ(motion.states.size(), whole.states.size());
  for (std::size_t i = 195; i < 225; ++i) {  // 5 s to 5.5 s
    EXPECT_LT((motion.states[i].T_WB.p() - whole.states[i].T_WB.p()).norm(), 2e-3);
  }
}

TEST(RecordedMotion, TenPosesASecondAreEnough) {
  Captured captured = Capture(8), few = captured;
  few.poses.clear();
  for (std::size_t i = 3; i < captured.poses.size(); i += 20)
    few.poses.push_back(captured.poses[i]);
  const RecordedMotion motion = Fit(few), whole = Fit(captured);
  EXPECT_GT(motion.consistency.position, 5e-4) << "poses that were captured are not guesses";
  const double t = ToSeconds(motion.begin - whole.begin);
  const auto shift = static_cast<std::size_t>(std::lround(t / whole.interval));
  ASSERT_NEAR(t, static_cast<double>(shift) * whole.interval, 0.011);
  EXPECT_LT((motion.states[200].v_WB - whole.states[200 + shift].v_WB).norm(), 0.1);
}

TEST(RecordedMotion, RefusesMostlyHolesAndReadingsOfAnotherUnit) {
  const Captured captured = Capture(9);
  Captured holes = captured;
  std::erase_if(holes.poses, [](const StampedPose& pose) {
    const double t = ToSeconds(pose.stamp);
    return t > 1.0 && t < 11.0;
  });
  EXPECT_THROW(Fit(holes), InvalidArgument);
  Captured degrees = captured;
  for (ImuSample& sample : degrees.readings) sample.gyroscope *= 180.0 / M_PI;
  EXPECT_THROW(Fit(degrees), InvalidArgument);
}

TEST(RecordedMotion, RefusesShortRecordingsAndGapsInTheReadings) {
  Captured captured = Capture(5);
  EXPECT_THROW(Fit({{}, captured.readings}), InvalidArgument);
  EXPECT_THROW(Fit({captured.poses, {captured.readings.begin(), captured.readings.begin() + 500}}),
               InvalidArgument);
  captured.readings.erase(captured.readings.begin() + 500, captured.readings.begin() + 540);
  EXPECT_THROW(Fit(captured), InvalidArgument);
}

TEST(RecordedRoom, TheCameraLooksLevelAndReadingsBelongToTheFrames) {
  const RecordedMotion motion = Fit(Capture(6));
  SimulationOptions options;
  options.duration = 5.0;
  options.camera = Scaled(options.camera, 0.1);
  options.imu.noise = kNoise;
  const Simulation room = SimulateRecordedRoom(motion, options);
  EXPECT_EQ(room.size(), 150);
  const std::vector<ImuSample> samples = room.ImuSamples();
  // The readings are those of the simulated motion.
  double squares = 0.0;
  int count = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const Stamp a = samples[i - 1].stamp, b = samples[i].stamp;
    if (a < room.StampOf(0) || b > room.StampOf(149)) continue;
    const TrueState from = room.StateAt(a), to = room.StateAt(b);
    const Eigen::Vector3d rate =
        so3::Log(from.state.T_WB.q().conjugate() * to.state.T_WB.q()) / ToSeconds(b - a);
    const Eigen::Vector3d read =
        0.5 * (samples[i - 1].gyroscope + samples[i].gyroscope) - from.bias.head<3>();
    squares += (read - rate).squaredNorm() / 3.0;
    ++count;
  }
  ASSERT_GT(count, 900);
  // The mean of two readings.
  EXPECT_NEAR(std::sqrt(squares / count), 2e-4 * std::sqrt(kHertz / 2.0), 6e-4);
  // Up in the image is up in the room while the body is upright.
  const Eigen::Vector3d up_B = motion.states[60].T_WB.q().conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up_C = LevelCamera(motion).conjugate() * up_B;
  EXPECT_LT(up_C.y(), -0.7);
}

TEST(RecordedRoom, IsAsLargeAsTheMotionNeeds) {
  RecordedMotion motion = Fit(Capture(7));
  SimulationOptions options;
  options.duration = 2.0;
  const auto width = [&] {
    const Simulation room = SimulateRecordedRoom(motion, options);
    double most = 0.0;
    for (const Eigen::Vector3d& v : room.scene().mesh.vertices) most = std::max(most, v.x());
    return most;
  };
  const double usual = width();
  EXPECT_NEAR(usual, 3.0, 1e-9);
  motion.states.back().T_WB =
      Pose(motion.states.back().T_WB.q(), motion.states.back().T_WB.p() + Eigen::Vector3d(6, 0, 0));
  EXPECT_GT(width(), 1.2 * usual);
}

}  // namespace
}  // namespace highwall::simulate::recorded_motion_test
