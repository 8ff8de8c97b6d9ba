#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/factors/adaptive_imu_weight.h>
#include <highwall/frontend/inertial/inertial_odometry.h>

#include "inertial_drive.h"

namespace highwall::inertial_odometry_test {
namespace {

using testing::AngleBetween;
using testing::Drive;
using testing::InertialScene;
using testing::InertialSceneOptions;
using testing::kBias;
using testing::kDegree;
using testing::kFirst;
using testing::kStep;
using testing::kTilted;
using testing::Shock;

void ExpectBiasWithinItsDeviations(const Drive& drive) {
  const InertialEstimate estimate = *drive.odometry.estimate();
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT(std::abs(estimate.bias(i) - drive.scene.bias()(i)),
              3.5 * std::sqrt(estimate.covariance(9 + i, 9 + i)))
        << i;
  }
}

TEST(InertialOdometry, InitializesInMotionAndLevelsTheMap) {
  Drive drive({.bias = kBias, .T_WN = kTilted});
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kWaiting);
  EXPECT_FALSE(drive.odometry.T_WC());
  EXPECT_FALSE(drive.odometry.gravity_W());
  EXPECT_EQ(drive.odometry.gravity_sigma(), M_PI);
  drive.Until(5.0);
  EXPECT_EQ(drive.Levels(), 2) << "in the beginning, and where gravity is known thrice as well";
  EXPECT_EQ(drive.reports.front().status, InertialStatus::kInitializing);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
  EXPECT_FALSE(drive.prediction == std::nullopt);
  EXPECT_LT(drive.PositionError(), 3e-3);
  EXPECT_LT(drive.AngleError(), 2e-3);
  // Up is z after the gravity alignment, and so is the true gravity direction.
  const Eigen::Vector3d truth = drive.T_map.q() * drive.scene.gravity_W();
  EXPECT_LT(AngleBetween(*drive.odometry.gravity_W(), truth), 0.3 * kDegree);
  EXPECT_LT(AngleBetween(truth, kGravity), 0.2 * kDegree);
  ExpectBiasWithinItsDeviations(drive);
  const InertialEstimate estimate = *drive.odometry.estimate();
  EXPECT_LT((estimate.state.v_WB - drive.T_map.q() * drive.scene.StateAt(drive.last).v_WB).norm(),
            0.02);
  EXPECT_EQ(drive.reports.back().innovation_dof, 6);
}

// At rest a tilt and a bias are indistinguishable; the motion that follows separates them.
TEST(InertialOdometry, LevelsTheMapAgainWhereGravityHasBecomeKnownBetter) {
  // The camera is far from the origin, about which a rotation of 1 degree would move it by a metre.
  Drive drive({.rest = 3.0,
               .bias = (ImuBias() << 0, 0, 0, 0.12, -0.1, 0).finished(),
               .T_WN = Pose(Eigen::Quaterniond::Identity(), {50.0, -30.0, 2.0})});
  drive.Until(2.5);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
  const auto tilt = [&] {
    return AngleBetween(drive.T_map.q() * drive.scene.gravity_W(), kGravity);
  };
  EXPECT_NEAR(tilt(), std::atan(std::hypot(0.12, 0.1) / 9.81), 0.1 * kDegree);
  drive.Until(20.0);
  EXPECT_LT(tilt(), 0.2 * kDegree);
  EXPECT_GE(drive.Levels(), 2);
  EXPECT_LE(drive.Levels(), 3);
  EXPECT_LT(drive.PositionError(), 3e-3);
  // Half a centimetre is the accuracy of a 0.1 s prediction for a body that was at rest at first.
  EXPECT_LT(drive.largest_step_of_a_turn, 5e-3) << "the camera stays where it was";
}

TEST(InertialOdometry, FindsTheTimeOffsetToAMillisecond) {
  for (const double offset : {-0.03, 0.03}) {
    Drive drive({.bias = kBias, .time_offset = offset});
    drive.Until(6.0);
    ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
    EXPECT_NEAR(drive.odometry.time_offset(), offset, 1e-3);
    EXPECT_LT(drive.odometry.time_offset_sigma(), 1e-3);
    EXPECT_LT(drive.PositionError(), 3e-3);
  }
}

TEST(InertialOdometry, AnOffsetThatIsNotEstimatedKeepsItsValue) {
  Drive drive({}, {.estimate_time_offset = false});
  drive.Until(3.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  EXPECT_EQ(drive.odometry.time_offset(), 0.0);
}

TEST(InertialOdometry, BridgesTwoSecondsWithoutImages) {
  Drive drive({.bias = kBias});
  drive.Until(6.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  const std::size_t seen = drive.reports.size();
  drive.Until(8.0, [](double) { return false; });
  for (std::size_t i = seen; i < drive.reports.size(); ++i) {
    EXPECT_EQ(drive.reports[i].status, InertialStatus::kDeadReckoning);
    EXPECT_EQ(drive.reports[i].innovation_dof, 0);
    EXPECT_TRUE(drive.reports[i].estimate);
  }
  // The bias of the accelerometer is known to 0.01 m/s^2, gravity to 0.001 rad: 0.02 m/s^2 over 2 s
  // are 4 cm; the path is 3 m.
  EXPECT_LT(drive.PositionError(), 0.06);
  const InertialEstimate estimate = *drive.odometry.estimate();
  const double sigma = std::sqrt(estimate.covariance.topLeftCorner(3, 3).trace());
  EXPECT_LT(drive.PositionError(), 4.0 * sigma);
  drive.Until(9.0);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  EXPECT_LT(drive.PositionError(), 3e-3);
}

TEST(InertialOdometry, StopsAfterTooLongWithoutImages) {
  Drive drive({}, {.max_dead_reckoning = 1.0});
  drive.Until(3.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  drive.Until(4.5, [](double) { return false; });
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kWaiting);
  EXPECT_FALSE(drive.odometry.T_WC());
  EXPECT_FALSE(drive.prediction);
  drive.Until(4.6);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kWaiting) << "one pose gives no velocity";
  EXPECT_FALSE(drive.reports.back().reason.empty());
  drive.Until(4.7);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kRunning) << "two images on";
  EXPECT_TRUE(drive.reports.back().restarted);
  drive.Until(4.5 + 3.0);
  EXPECT_LT(drive.PositionError(), 3e-3);
}

// Drops the readings between two instants [s].
std::function<bool(ImuSample&)> Gap(double from, double to) {
  return [=](const ImuSample& reading) {
    const double t = ToSeconds(reading.stamp);
    return t < from || t > to;
  };
}

// Not every image is one of those by which it is initialized, which are a tenth of a second apart.
TEST(InertialOdometry, BeginsWithTheImageOfWhichItIsInitialized) {
  for (const double end : {0.25, 0.45, 0.65, 0.85}) {  // [s] of a gap, until a second after which
    Drive drive({.bias = kBias});
    drive.change = Gap(0.2, end);
    drive.step = 0.04;
    while (drive.odometry.status() != InertialStatus::kRunning) {
      drive.Until(drive.Stamp());
      ASSERT_LT(drive.last, 5.0) << end;
    }
    ASSERT_GT(drive.last, 1.0 + end);
    // [ns] that the first image may move the time offset; the one before is 40 ms earlier.
    EXPECT_NEAR(static_cast<double>(drive.odometry.estimate()->stamp),
                1e9 * (drive.last + drive.odometry.time_offset()), 1e5);
    // An image is accurate to 2 mm per axis; the body moves 50 mm in 40 ms.
    EXPECT_LT(drive.PositionError(), 6e-3) << end;
  }
}

TEST(InertialOdometry, RestartsAfterAGapInTheReadings) {
  Drive drive({.bias = kBias});
  drive.change = Gap(4.153, 4.283);
  drive.Until(4.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  const ImuBias before = drive.odometry.estimate()->bias;
  drive.Until(4.21);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kWaiting) << "within the gap";
  drive.Until(4.31);
  EXPECT_TRUE(drive.reports.back().restarted);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  EXPECT_LT((drive.odometry.estimate()->bias - before).norm(), 0.01) << "biases outlast the gap";
  EXPECT_LT(drive.PositionError(), 5e-3);
  drive.Until(5.0);
  EXPECT_FALSE(drive.reports.back().restarted);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  EXPECT_LT(drive.PositionError(), 3e-3);
}

TEST(InertialOdometry, RejectsReadingsThatImagesContradict) {
  // The impact is within one interval of the images, or spans an image: two are inconsistent.
  for (const double from : {4.22, 4.27}) {
    Drive drive({.bias = kBias});
    drive.change = Shock(from, from + 0.06);
    drive.Until(4.21);
    ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
    const ImuBias before = drive.odometry.estimate()->bias;
    drive.Until(4.31);
    EXPECT_TRUE(drive.reports.back().contradicted) << from;
    EXPECT_TRUE(drive.reports.back().restarted) << from;
    EXPECT_GT(drive.reports.back().squared_innovation, 100.0);
    EXPECT_EQ(drive.reports.back().weight, 0.0) << "no IMU factor";
    ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
    drive.Until(4.41);
    EXPECT_EQ(drive.reports.back().contradicted, from > 4.25) << from;
    EXPECT_LT(drive.PositionError(), 5e-3) << from;
    EXPECT_FALSE(drive.odometry.Between(FromSeconds(4.1), FromSeconds(4.4)))
        << "nor do these readings tie keyframes";
    EXPECT_TRUE(drive.odometry.IsContradicted(FromSeconds(4.1), FromSeconds(4.4)));
    EXPECT_TRUE(drive.odometry.AllBetween(FromSeconds(4.1), FromSeconds(4.4)));
    EXPECT_FALSE(drive.odometry.IsContradicted(FromSeconds(3.8), FromSeconds(4.15)));
    EXPECT_TRUE(drive.odometry.Between(FromSeconds(3.8), FromSeconds(4.15)));
    EXPECT_LT((drive.odometry.estimate()->bias - before).norm(), 0.01);
    drive.Until(5.5);
    EXPECT_FALSE(drive.reports.back().contradicted);
    EXPECT_LT(drive.PositionError(), 3e-3) << from;
  }
}

TEST(InertialOdometry, GivesReadingsAtTheLimitOfAKnownRangeLittleWeight) {
  constexpr double kRange = 9.81, kFrom = 4.0, kTo = 5.5;  // [m/s^2] gravity alone; [s]
  const auto ends = [=](ImuSample& reading) {
    if (const double t = ToSeconds(reading.stamp); t > kFrom && t < kTo) {
      reading.accelerometer = reading.accelerometer.cwiseMax(-kRange).cwiseMin(kRange);
    }
    return true;
  };
  // Without a known range, saturated readings are trusted, or rejected as a whole.
  Drive informed({.bias = kBias}, {}, Pose(), kRange), uninformed({.bias = kBias});
  informed.change = uninformed.change = ends;
  informed.Until(3.9);
  ASSERT_EQ(informed.odometry.status(), InertialStatus::kRunning);
  double informed_error = 0.0, uninformed_error = 0.0;
  for (double t = 4.0; t < kTo; t += kStep) {
    informed.Until(t);
    uninformed.Until(t);
    informed_error = std::max(informed_error, informed.PositionError());
    uninformed_error = std::max(uninformed_error, uninformed.PositionError());
    EXPECT_FALSE(informed.reports.back().contradicted) << t;
  }
  const auto saturated = [](const Drive& drive) {
    return std::ranges::count_if(drive.reports, &InertialReport::saturated);
  };
  EXPECT_GE(saturated(informed), 5) << "of fifteen";
  EXPECT_EQ(saturated(uninformed), 0);
  // An image is accurate to 2 mm per axis.
  EXPECT_LT(informed_error, 6e-3);
  EXPECT_GT(uninformed_error, 1.5 * informed_error);
  informed.Until(7.0);
  EXPECT_FALSE(informed.reports.back().saturated);
  EXPECT_LT(informed.PositionError(), 3e-3);
  ExpectBiasWithinItsDeviations(informed);
}

TEST(InertialOdometry, AnImageThatLeapsContradictsNoReadings) {
  Drive drive({.bias = kBias});
  drive.Until(4.21);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  const Pose T_map = drive.T_map;
  drive.T_map = drive.T_map * Pose(Eigen::Quaterniond::Identity(), {0.5, 0.0, 0.0});
  drive.Until(4.31);
  EXPECT_GT(drive.reports.back().squared_innovation, 100.0);
  EXPECT_FALSE(drive.reports.back().contradicted);
  drive.T_map = T_map;
}

TEST(InertialOdometry, RestartedItFindsGravityInAnotherWorld) {
  Drive drive({.bias = kBias, .T_WN = kTilted});
  drive.Until(5.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  drive.odometry.Restart();
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kWaiting);
  EXPECT_FALSE(drive.odometry.T_WC());
  EXPECT_FALSE(drive.odometry.gravity_W());
  EXPECT_FALSE(drive.odometry.Predict(FromSeconds(drive.Stamp())));
  // The images' poses are in a world at another place that is not aligned with gravity.
  drive.T_map = Pose::FromTangent({-7, 4, 1}, {-0.2, 0.25, 2.0});
  const int before = drive.Levels();
  drive.Until(10.0);
  EXPECT_EQ(drive.Levels() - before, 1);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  EXPECT_LT(drive.PositionError(), 5e-3);  // as after a gap in the readings
  EXPECT_LT(AngleBetween(*drive.odometry.gravity_W(), -Eigen::Vector3d::UnitZ()), 0.5 * kDegree);
}

TEST(InertialOdometry, KeepsBiasesGravityAndOffsetOverALongGap) {
  Drive drive({.bias = kBias, .time_offset = 0.012, .T_WN = kTilted});
  drive.change = Gap(4.05, 4.6);
  drive.Until(4.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  const InertialEstimate before = *drive.odometry.estimate();
  const Eigen::Vector3d gravity = *drive.odometry.gravity_W();
  drive.Until(4.5);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kWaiting);
  EXPECT_FALSE(drive.odometry.T_WC()) << "the images alone";
  drive.Until(4.61);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
  EXPECT_TRUE(drive.reports.back().restarted);
  const InertialEstimate after = *drive.odometry.estimate();
  EXPECT_LT((after.bias - before.bias).norm(), 1e-3);
  EXPECT_NEAR(drive.odometry.time_offset(), 0.012, 1e-3);
  EXPECT_LT(AngleBetween(*drive.odometry.gravity_W(), gravity), 0.1 * kDegree);
  EXPECT_GT(after.covariance(9, 9), before.covariance(9, 9)) << "biases walked in the meantime";
  drive.Until(7.0);
  EXPECT_LT(drive.PositionError(), 3e-3);
  EXPECT_EQ(drive.Levels(), 2) << "the end of the gap levels nothing";
}

TEST(InertialOdometry, AMapThatMovesDuringAGapTakesTheEstimateAlong) {
  Drive drive({.bias = kBias});
  drive.change = Gap(4.05, 4.6);
  drive.Until(4.3);
  ASSERT_FALSE(drive.odometry.T_WC());
  const Pose T_new_old = Pose::FromTangent({0.4, -0.2, 0.1}, {0, 0, 0.3});
  drive.T_map = T_new_old * drive.T_map;
  drive.odometry.MoveMap(T_new_old);
  drive.Until(6.0);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  EXPECT_LT(drive.PositionError(), 3e-3);
}

TEST(InertialOdometry, AMapThatMovesDuringTheInitializationDoesNotDisturbIt) {
  Drive still({.bias = kBias, .T_WN = kTilted});
  still.Until(1.5);
  ASSERT_EQ(still.odometry.status(), InertialStatus::kRunning) << "it takes no longer at rest";
  Drive drive({.bias = kBias, .T_WN = kTilted});
  drive.Until(0.7);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kInitializing);
  // A local adjustment moves the map by 2 cm and 0.3 degrees.
  const Pose T_new_old = Pose::FromTangent({0.01, -0.015, 0.008}, {0.003, 0.003, -0.003});
  drive.odometry.MoveMap(T_new_old);
  drive.T_map = T_new_old * drive.T_map;
  drive.Until(1.5);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kRunning) << drive.reports.back().reason;
  EXPECT_LT(AngleBetween(*drive.odometry.gravity_W(), drive.T_map.q() * drive.scene.gravity_W()),
            1.0 * kDegree);
}

TEST(InertialOdometry, ResumesRightAfterTheMapWasLevelled) {
  const InertialSceneOptions scene{.bias = kBias, .T_WN = kTilted};
  const InertialOptions options{.buffer = {.max_step = 0.05}};
  Drive first(scene, options);
  first.Until(3.0);
  std::size_t levelled = 0;
  while (levelled < first.reports.size() && !first.reports[levelled].T_gravity) ++levelled;
  ASSERT_LT(levelled, first.reports.size());

  const double t = kFirst + kStep * static_cast<double>(levelled);
  Drive drive(scene, options);
  drive.change = Gap(t + 0.012, t + kStep - 0.018);
  drive.Until(t + kStep);
  ASSERT_TRUE(drive.reports[levelled].T_gravity);
  ASSERT_TRUE(drive.reports.back().restarted);
  const Eigen::Vector3d truth = drive.T_map.q() * drive.scene.StateAt(drive.last).v_WB;
  // The velocity is the mean of the last 0.1 s, at accelerations below 4 m/s^2, with 1 mm of noise.
  EXPECT_LT((drive.odometry.estimate()->state.v_WB - truth).norm(), 0.25);
}

TEST(InertialOdometry, AReadingBeyondAnySensorIsRefusedAndChangesNothing) {
  for (const double spike : {1e5, 1e6, 3e7, 1e9}) {
    SCOPED_TRACE(spike);
    Drive drive({.bias = kBias});
    int refused = 0;
    drive.change = [&](ImuSample& reading) {
      if (std::abs(ToSeconds(reading.stamp) - 3.0) > 1e-6) return true;
      reading.accelerometer.x() = spike;
      refused += drive.odometry.AddSample(reading) == ImuSampleStatus::kImpossible ? 1 : 0;
      return false;
    };
    drive.Until(5.0);
    EXPECT_EQ(refused, 1);
    EXPECT_EQ(drive.odometry.status(), InertialStatus::kRunning);
    for (const InertialReport& report : drive.reports) EXPECT_FALSE(report.restarted);
    EXPECT_LT(drive.PositionError(), 3e-3);
  }
}

TEST(InertialOdometry, AWindowThatCannotStartStaysSuspendedUntilOneCan) {
  Drive drive({.bias = kBias});
  drive.change = Gap(4.05, 4.53);
  drive.Until(4.5);
  ASSERT_EQ(drive.odometry.status(), InertialStatus::kWaiting);
  // One image is so far away that the velocity before and after it is not finite.
  const Pose T_map = drive.T_map;
  drive.T_map = Pose(T_map.q(), Eigen::Vector3d(1.5e308, 0.0, 0.0));
  ASSERT_NO_THROW(drive.Until(4.6));
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kWaiting);
  EXPECT_FALSE(drive.odometry.T_WC());
  EXPECT_FALSE(drive.reports.back().reason.empty());
  drive.T_map = T_map;
  ASSERT_NO_THROW(drive.Until(4.7));
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kWaiting);
  drive.Until(4.8);
  EXPECT_TRUE(drive.reports.back().restarted);
  drive.Until(7.0);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  EXPECT_LT(drive.PositionError(), 3e-3);
}

TEST(InertialOdometry, WithoutReadingsItWaits) {
  Drive drive;
  drive.change = [](ImuSample&) { return false; };
  drive.Until(1.0);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kWaiting);
  EXPECT_FALSE(drive.reports.back().reason.empty());
  EXPECT_FALSE(drive.prediction);
  EXPECT_FALSE(drive.odometry.UpInCamera(FromSeconds(0.5)));
}

TEST(InertialOdometry, ReadingsThatEndLeaveTheImagesAlone) {
  Drive drive;
  drive.change = [](ImuSample& reading) { return ToSeconds(reading.stamp) < 4.0; };
  drive.Until(6.0);
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kWaiting);
  EXPECT_FALSE(drive.odometry.T_WC());
}

TEST(InertialOdometry, MovingTheMapMovesTheEstimateAlong) {
  Drive drive({.bias = kBias});
  drive.Until(4.0);
  const InertialEstimate before = *drive.odometry.estimate();
  const Eigen::Vector3d gravity = *drive.odometry.gravity_W();
  // A loop correction rotates about the vertical and shifts; states and images move together.
  const Pose T = Pose::FromTangent({0.5, -0.3, 0.2}, {0, 0, 0.4});
  drive.odometry.MoveMap(T);
  drive.T_map = T * drive.T_map;
  const InertialEstimate after = *drive.odometry.estimate();
  EXPECT_TRUE(after.state.T_WB.Matrix().isApprox((T * before.state.T_WB).Matrix(), 1e-12));
  EXPECT_TRUE(after.state.v_WB.isApprox(T.q() * before.state.v_WB, 1e-12));
  EXPECT_EQ(after.bias, before.bias);
  EXPECT_TRUE(drive.odometry.gravity_W()->isApprox(T.q() * gravity, 1e-12));
  const Eigen::Matrix3d P = before.covariance.topLeftCorner(3, 3);
  const Eigen::Matrix3d turned = T.R() * P * T.R().transpose();
  EXPECT_TRUE(after.covariance.topLeftCorner(3, 3).isApprox(turned, 1e-10));
  const std::size_t first = drive.reports.size();
  drive.Until(5.0);
  EXPECT_LT(drive.PositionError(), 3e-3);
  // The images are not affected: no innovation exceeds that of noise, 6 on average.
  for (std::size_t i = first; i < drive.reports.size(); ++i) {
    EXPECT_LT(drive.reports[i].squared_innovation, 35.0) << i;
    EXPECT_FALSE(drive.reports[i].restarted);
  }
}

TEST(InertialOdometry, AMapThatTiltsLeavesUpWhereItWas) {
  Drive drive;
  drive.Until(4.0);
  const Eigen::Vector3d p = drive.odometry.estimate()->state.T_WB.p();
  const Eigen::Vector3d gravity = *drive.odometry.gravity_W();
  const Pose T = Pose::FromTangent({0.1, 0.2, 0.3}, {0.02, -0.01, 0.1});
  drive.odometry.MoveMap(T);
  EXPECT_LT(AngleBetween(*drive.odometry.gravity_W(), kGravity),
            AngleBetween(gravity, kGravity) + 1e-9);
  EXPECT_TRUE(drive.odometry.estimate()->state.T_WB.p().isApprox(T * p, 1e-12))
      << "the place moves";
}

TEST(InertialOdometry, FindsUpInTheCameraAtRest) {
  InertialScene scene({.motion = 0.0});
  InertialOdometry odometry(scene.calibration());
  for (const ImuSample& reading : scene.Readings(0.0, 1.0)) odometry.AddSample(reading);
  const auto up = odometry.UpInCamera(FromSeconds(0.9));
  ASSERT_TRUE(up);
  EXPECT_LT(AngleBetween(scene.T_WC(0.9).q() * *up, -kGravity), 1e-3);
  EXPECT_FALSE(odometry.UpInCamera(FromSeconds(2.0))) << "no readings there";
  InertialOdometry in_g(scene.calibration());
  for (ImuSample reading : scene.Readings(0.0, 1.0)) {
    reading.accelerometer /= 9.81;
    in_g.AddSample(reading);
  }
  EXPECT_FALSE(in_g.UpInCamera(FromSeconds(0.9)));
}

// Returns the weights of the intervals since the odometry has been running.
std::vector<double> Weights(const Drive& drive) {
  EXPECT_EQ(drive.odometry.status(), InertialStatus::kRunning);
  EXPECT_LT(drive.PositionError(), 5e-3);
  std::vector<double> weights;
  for (const InertialReport& report : drive.reports) {
    if (report.innovation_dof > 0) weights.push_back(report.weight);
  }
  EXPECT_GT(weights.size(), 10u);
  EXPECT_EQ(weights.back(), drive.odometry.weight());
  return weights;
}

TEST(InertialOdometry, PaperWeighsByTheMotionTheBlurAndTheFeaturesThatAreLost) {
  constexpr ImuWeightingOptions kPaper{.policy = ImuWeighting::kPaper};
  const PaperImuWeightOptions paper;
  Drive rest({.motion = 0.0}, {.weighting = kPaper});
  rest.Until(4.0);
  for (const double weight : Weights(rest)) EXPECT_EQ(weight, paper.weight_at_rest);
  // Twice the usual motion rotates at 1 rad/s and more.
  Drive rapid({.motion = 2.0, .bias = kBias}, {.weighting = kPaper});
  rapid.Until(4.0);
  for (const double weight : Weights(rapid)) EXPECT_GE(weight, paper.weight_rapid);
  Drive blurred({.motion = 0.0}, {.weighting = kPaper});
  blurred.sharpness = 0.6;  // half of the ramp
  blurred.Until(4.0);
  const double half = 0.5 * (paper.weight_slow + paper.weight_rapid);
  for (const double weight : Weights(blurred)) EXPECT_NEAR(weight, half, 1e-9);
  Drive lost({.motion = 0.0}, {.weighting = kPaper});
  lost.tracked_share = 0.3;
  lost.Until(4.0);
  for (const double weight : Weights(lost)) EXPECT_EQ(weight, paper.weight_max);
}

TEST(InertialOdometry, ConsistentWeighsOneUntilTheReadingsAreWorseThanTheySay) {
  Drive drive({.bias = kBias}, {.weighting = {.policy = ImuWeighting::kConsistent}});
  drive.Until(4.0);
  for (const double weight : Weights(drive)) EXPECT_EQ(weight, 1.0) << "readings are as they say";
  const double root = std::sqrt(200.0);
  drive.change = [&](ImuSample& reading) {
    reading.accelerometer +=
        drive.scene.Noise(50.0 * drive.scene.calibration().noise.accelerometer * root);
    return true;
  };
  drive.Until(6.0);
  EXPECT_LT(drive.odometry.weight(), 0.5);
  drive.change = [](ImuSample&) { return true; };
  drive.Until(10.0);
  EXPECT_EQ(drive.odometry.weight(), 1.0) << "and again when they are better";
}

TEST(InertialOdometry, AFixedWeightIsThatOfTheReadings) {
  // A tenth of the weight gives ten times the covariance of the readings alone.
  double variances[2];
  for (const bool light : {false, true}) {
    const double weight = light ? 0.1 : 1.0;
    Drive drive({.bias = kBias},
                {.weighting = {.policy = ImuWeighting::kFixed, .fixed_weight = weight}});
    drive.Until(4.0);
    for (const double w : Weights(drive)) EXPECT_EQ(w, weight);
    const double before = drive.odometry.estimate()->covariance.topLeftCorner(3, 3).trace();
    drive.Until(5.0, [](double) { return false; });
    variances[light ? 1 : 0] =
        drive.odometry.estimate()->covariance.topLeftCorner(3, 3).trace() - before;
  }
  EXPECT_GT(variances[1], 2.0 * variances[0]);
  EXPECT_LT(variances[1], 12.0 * variances[0]);
}

}  // namespace
}  // namespace highwall::inertial_odometry_test
