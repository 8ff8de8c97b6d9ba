// SlamSystem with an IMU, in a rendered room.
#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/inertial/inertial_odometry.h>
#include <highwall/frontend/system/slam_system.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <simulate/scenes/room.h>

#include "features/row_times.h"
#include "support/rendered_walk.h"

namespace highwall::slam_inertial_test {
namespace {

using testing::RenderedWalk;

constexpr int kFrames = 60;
constexpr double kFps = 10.0;
constexpr double kTimeOffset = 0.012;                 // [s] not known to the system
constexpr std::size_t kDark = 40, kBrightAgain = 52;  // frames with the lens covered

PinholeCamera SmallCamera() {
  return {.width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
}

// Returns the angle between two vectors [rad].
double AngleTo(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Six seconds of a walk with an IMU, rendered once for all tests.
class SlamInertialTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    simulate::SimulationOptions options;
    options.seed = 3;
    options.fps = kFps;
    options.duration = kFrames / kFps;
    options.camera = SmallCamera();
    options.sensor.noise = simulate::SensorNoise::kKinect;
    options.imu.time_offset = kTimeOffset;
    // The tolerances of the dark interval are those of the specified noise.
    options.sensor.noise_ratio = options.imu.noise_ratio = 1.0;
    walk_ = std::make_unique<RenderedWalk>(testing::Render(simulate::SimulateRoom(options)));
  }
  static void TearDownTestSuite() { walk_.reset(); }

  // Returns the results of the frames of [0, end), where those of [kDark, kBrightAgain) are blank.
  static std::vector<FrameResult> Run(SlamSystem& system, std::size_t end = kFrames) {
    return Run(system, end, walk_->readings);
  }
  static std::vector<FrameResult> Run(SlamSystem& system, std::size_t end,
                                      const std::vector<ImuSample>& readings) {
    std::vector<FrameResult> results;
    std::size_t next = 0;
    for (std::size_t i = 0; i < end; ++i) {
      RgbdImage image = walk_->images[i];
      for (; next < readings.size() && readings[next].stamp < image.stamp + FromSeconds(0.1);
           ++next) {
        system.AddImu(readings[next]);
      }
      if (i >= kDark && i < kBrightAgain) {
        image.bgr = cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(3));
        image.depth = cv::Mat(240, 320, CV_32FC1, cv::Scalar(0.0));
      }
      results.push_back(system.Track(image));
    }
    return results;
  }
  static const RenderedWalk& walk() { return *walk_; }

 private:
  static std::unique_ptr<const RenderedWalk> walk_;
};

std::unique_ptr<const RenderedWalk> SlamInertialTest::walk_;

TEST_F(SlamInertialTest, InitializesBridgesADarknessAndRepeatsBitForBit) {
  const RgbdSensor sensor{.camera = SmallCamera()};
  SlamSystem system(sensor, Deterministic({}), {.imu = walk().calibration});
  const std::vector<FrameResult> results = Run(system);
  // After the dark interval the place is not mapped: the IMU extrapolates until a map is begun
  // there.
  std::size_t back = kBrightAgain;
  while (back < results.size() && results[back].state == TrackingState::kInertial) ++back;
  EXPECT_LE(back, kBrightAgain + 8);
  Trajectory causal;
  int levels = 0;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const FrameResult& result = results[i];
    const bool carried = i >= kDark && i < back;
    EXPECT_EQ(result.state, carried ? TrackingState::kInertial : TrackingState::kTracking) << i;
    if (i > 0) {
      ASSERT_TRUE(result.inertial) << i;
      levels += result.inertial->T_gravity ? 1 : 0;
    }
    causal.push_back({result.stamp, result.T_WC});
  }
  EXPECT_EQ(levels, 2) << "again where gravity is known thrice as well";
  ASSERT_TRUE(results[35].inertial->estimate) << results[35].inertial->reason;
  EXPECT_EQ(results[35].inertial->status, InertialStatus::kRunning);
  EXPECT_EQ(results[kDark].inertial->status, InertialStatus::kDeadReckoning);
  EXPECT_EQ(results.back().inertial->status, InertialStatus::kRunning);

  // Every frame has a pose; the path in the dark is two thirds of a metre.
  const Trajectory trajectory = system.trajectory();
  ASSERT_EQ(trajectory.size(), walk().images.size());
  EXPECT_LT(AbsolutePoseError(walk().truth, trajectory).statistics.rmse, 0.02);
  EXPECT_LT(AbsolutePoseError(walk().truth, trajectory).statistics.max, 0.06);
  EXPECT_NEAR(results.back().inertial->time_offset, kTimeOffset, 3e-3);

  // Up is z: the true up direction in the camera is also up by the estimate.
  const Eigen::Vector3d up_C = walk().truth.back().pose.q().conjugate() * Eigen::Vector3d::UnitZ();
  const double angle = std::acos((trajectory.back().pose.q() * up_C).normalized().z());
  EXPECT_LT(angle, 0.2 * M_PI / 180.0);
  ASSERT_TRUE(system.map().gravity_W());
  EXPECT_LT((*system.map().gravity_W() - Eigen::Vector3d(0, 0, -9.81)).norm(), 0.1);

  SlamSystem again(sensor, Deterministic({}), {.imu = walk().calibration});
  const std::vector<FrameResult> repeated = Run(again);
  for (std::size_t i = 0; i < results.size(); ++i) {
    ASSERT_EQ(repeated[i].T_WC.Matrix(), results[i].T_WC.Matrix()) << i;
  }
  const Trajectory repeated_trajectory = again.trajectory();
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    ASSERT_EQ(repeated_trajectory[i].pose.Matrix(), trajectory[i].pose.Matrix()) << i;
  }
}

// Images from before gravity is known are smoothed by readings as well.
TEST_F(SlamInertialTest, ReadingsFromBeforeItsInitializationSmoothTheBeginning) {
  SlamSystem system({.camera = SmallCamera()}, Deterministic({}), {.imu = walk().calibration});
  const std::vector<FrameResult> results = Run(system, kDark);
  const auto start = static_cast<std::ptrdiff_t>(
      std::ranges::find_if(
          results, [](const FrameResult& r) { return r.inertial && r.inertial->estimate; }) -
      results.begin());
  system.Finish();
  const Trajectory all = system.trajectory();
  ASSERT_EQ(all.size(), kDark);
  const Trajectory beginning(all.begin(), all.begin() + start);
  // 1.6 mm without these readings, 0.4 mm with them.
  EXPECT_LT(RelativePoseError(walk().truth, beginning).statistics.rmse, 6e-4);
}

// The time offset, unknown to the system, is estimated anew when the IMU is initialized: readings
// hold the frames before and after.
TEST_F(SlamInertialTest, AnotherTimeOffsetDoesNotPartTheSmoothedTrajectory) {
  SlamSystem system({.camera = SmallCamera()}, Deterministic({}), {.imu = walk().calibration});
  Run(system, kDark);
  system.Finish();
  // 1.9 mm if frames between which the offset changed are smoothed apart, 0.4 mm here.
  EXPECT_LT(RelativePoseError(walk().truth, system.trajectory()).statistics.max, 1e-3);
}

// A shock to the sensor that the camera does not make.
TEST_F(SlamInertialTest, AShockToTheSensorDoesNotBendTheSmoothedTrajectory) {
  constexpr double kBegin = 3.43, kEnd = 3.45;  // [s] between two images
  SlamSystem system({.camera = SmallCamera()}, Deterministic({}), {.imu = walk().calibration});
  std::vector<ImuSample> readings = walk().readings;
  const Stamp first = walk().images.front().stamp + FromSeconds(kTimeOffset);
  for (ImuSample& reading : readings) {
    const double t = ToSeconds(reading.stamp - first);
    if (t < kBegin || t > kEnd) continue;
    reading.accelerometer += Eigen::Vector3d(10.0, -15.0, 5.0);
    reading.gyroscope += Eigen::Vector3d(0.5, 1.0, -0.7);
  }
  const std::vector<FrameResult> results = Run(system, kDark, readings);
  EXPECT_TRUE(std::ranges::any_of(results, [](const FrameResult& result) {
    return result.inertial && result.inertial->contradicted;
  }));
  system.Finish();
  // 4.0 mm if these readings are believed, 1.5 mm here.
  EXPECT_LT(RelativePoseError(walk().truth, system.trajectory()).statistics.max, 2.2e-3);
}

// Keyframes from before the initialization were compensated by the motion from one frame to the
// next.
TEST_F(SlamInertialTest, RowsOfTheFirstKeyframeFollowTheReadings) {
  // The images have no row times: those that are stated move each feature by the camera's motion.
  const FrameTiming timing{.colour_readout = 0.03};
  const auto first_keyframe = [&](FrameTimingMode mode) {
    SlamOptions options = Deterministic({});
    options.tracker.timing = mode;
    SlamSystem system({.camera = SmallCamera(), .timing = timing}, options,
                      {.imu = walk().calibration});
    Run(system, kDark);
    system.Finish();
    return system.map().keyframe(system.map().keyframe_ids().front())->frame.features;
  };
  const auto as_extracted = first_keyframe(FrameTimingMode::kIgnored);
  const auto found = first_keyframe(FrameTimingMode::kKnown);
  const Trajectory& truth = walk().truth;
  const auto expected =
      CompensatedToMiddleRow(*as_extracted, SmallCamera(), timing.colour_readout,
                             Twist::Between(truth[0].pose.Inverse() * truth[1].pose, 1.0 / kFps));
  ASSERT_EQ(found->points.size(), expected->points.size());
  double error = 0.0, shift = 0.0;  // [px] sums
  for (std::size_t i = 0; i < found->points.size(); ++i) {
    const Eigen::Vector2d& uv = expected->points[i].uv;
    error += (found->points[i].uv - uv).norm();
    shift += (as_extracted->points[i].uv - uv).norm();
  }
  const auto points = static_cast<double>(found->points.size());
  EXPECT_GT(shift / points, 0.5);
  // 0.043 by the motion until the next frame, 0.005 by the readings.
  EXPECT_LT(error / points, 0.015);
}

// The lens is covered for longer than dead reckoning is trusted, and an unmapped place follows: the
// submap that begins there has its own world frame, in which up is known from the first frame on.
TEST_F(SlamInertialTest, ASubmapThatBeginsWhereDeadReckoningHasEndedIsUpright) {
  SlamOptions options = Deterministic({});
  options.inertial.max_dead_reckoning = 0.5;
  SlamSystem system({.camera = SmallCamera()}, options, {.imu = walk().calibration});
  const std::vector<FrameResult> results = Run(system);
  const FrameResult& last_dark = results[kBrightAgain - 1];
  EXPECT_EQ(last_dark.state, TrackingState::kLost);
  EXPECT_EQ(last_dark.reason, LossReason::kDark);
  std::size_t begin = kBrightAgain;
  while (begin < results.size() && !results[begin].begins_submap) ++begin;
  ASSERT_LT(begin, results.size());
  EXPECT_EQ(begin, kBrightAgain) << "the lost timeout is over: the first frame that can";
  // Up is the mean acceleration of a second, in which a walk changes its velocity by less than half
  // a metre per second: 3 deg.
  constexpr double kUpright = 0.05;  // [rad]
  for (std::size_t i = begin; i < results.size(); ++i) {
    EXPECT_EQ(results[i].submap, results[begin].submap) << i;
    const Eigen::Vector3d up_C = walk().truth[i].pose.q().conjugate() * Eigen::Vector3d::UnitZ();
    EXPECT_LT(AngleTo(results[i].T_WC.q() * up_C, Eigen::Vector3d::UnitZ()), kUpright) << i;
  }
  const Eigen::Vector3d up_C = walk().truth[begin].pose.q().conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_GT(AngleTo(up_C, -Eigen::Vector3d::UnitY()), 2.0 * kUpright) << "it is not held level";
  EXPECT_EQ(system.submaps().size(), 2U);
}

// A mount given the wrong way round is found; the result is that of the images alone.
TEST_F(SlamInertialTest, AnInvertedMountIsFoundAndDoesNoHarm) {
  ImuCalibration inverted = walk().calibration;
  inverted.T_BC = inverted.T_BC.Inverse();
  SlamSystem system({.camera = SmallCamera()}, Deterministic({}), {.imu = inverted});
  std::vector<SensorFinding> findings;
  system.SetCallbacks(
      {.on_finding = [&](const SensorFinding& finding) { findings.push_back(finding); }});
  const std::vector<FrameResult> results = Run(system, kDark);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().fault, SensorFault::kImuMount) << findings.front().text;
  EXPECT_EQ(system.verdict().trust(), Trust::kDoubtful);
  EXPECT_EQ(results.back().inertial->status, InertialStatus::kGivenUp);
  EXPECT_FALSE(results.back().inertial->reason.empty());
  EXPECT_FALSE(system.map().gravity_W());
  for (const KeyFrameId id : system.map().keyframe_ids()) {
    const auto& motion = system.map().keyframe(id)->motion;
    EXPECT_TRUE(!motion || motion->previous == kNoId) << "an IMU factor is left";
  }

  SlamSystem alone({.camera = SmallCamera()}, Deterministic({}));
  for (std::size_t i = 0; i < kDark; ++i) alone.Track(walk().images[i]);
  const auto error = [](const SlamSystem& slam) {
    return AbsolutePoseError(walk().truth, slam.trajectory()).statistics.rmse;
  };
  EXPECT_LT(error(system), 1.1 * error(alone));
}

TEST_F(SlamInertialTest, ARightMountIsNotDoubted) {
  SlamSystem system({.camera = SmallCamera()}, Deterministic({}), {.imu = walk().calibration});
  Run(system, kDark);
  EXPECT_TRUE(system.verdict().findings.empty());
}

TEST_F(SlamInertialTest, ReadingsConstrainConsecutiveKeyFrames) {
  SlamSystem system({.camera = SmallCamera()}, Deterministic({}), {.imu = walk().calibration});
  Run(system, kDark);
  int tied = 0;
  const Map& map = system.map();
  for (const KeyFrameId id : map.keyframe_ids()) {
    const auto& motion = map.keyframe(id)->motion;
    if (!motion || motion->previous == kNoId) continue;
    ++tied;
    ASSERT_NE(map.keyframe(motion->previous), nullptr) << "a tie to one that is gone";
    ASSERT_NE(motion->from_previous, nullptr);
    EXPECT_EQ(motion->from_previous->end(), motion->stamp);
    EXPECT_EQ(motion->from_previous->start(), map.keyframe(motion->previous)->motion->stamp);
  }
  EXPECT_GE(tied, 1);
}

// The weight of an interval between keyframes is the mean over its images, including the last one,
// not the weight of the last one.
TEST_F(SlamInertialTest, AnIntervalOfManyImagesHasTheirMeanWeight) {
  SlamOptions options = Deterministic({});
  options.inertial.weighting.policy = ImuWeighting::kPaper;
  SlamSystem system({.camera = SmallCamera()}, options, {.imu = walk().calibration});
  double sum = 0.0;
  int images = 0;
  double last = 0.0;
  bool differs = false;
  system.SetCallbacks({.on_frame = [&](const FrameResult& result) {
    if (result.inertial && result.inertial->weight > 0.0) {
      last = result.inertial->weight;
      sum += last;  // the images are equally spaced
      ++images;
    }
    if (!result.mapping) return;
    const KeyFrame& keyframe = *system.map().keyframe(result.mapping->keyframe);
    if (keyframe.motion && keyframe.motion->previous != kNoId) {
      // Stamps are rounded to nanoseconds.
      EXPECT_NEAR(keyframe.motion->weight, sum / images, 1e-7);
      differs |= std::abs(last - sum / images) > 1e-3;
    }
    sum = 0.0;
    images = 0;
  }});
  Run(system);
  EXPECT_TRUE(differs) << "the dark and what follows change the weight";
}

TEST_F(SlamInertialTest, AnImuThatContradictsTheImagesChangesNothing) {
  // The readings are negated: the system continues with images alone, which determine the
  // trajectory.
  SlamSystem system({.camera = SmallCamera()}, Deterministic({}), {.imu = walk().calibration});
  std::size_t next = 0;
  for (std::size_t i = 0; i < kDark; ++i) {
    for (; next < walk().readings.size() &&
           walk().readings[next].stamp < walk().images[i].stamp + FromSeconds(0.1);
         ++next) {
      ImuSample reading = walk().readings[next];
      reading.gyroscope *= -1.0;
      reading.accelerometer *= -1.0;
      system.AddImu(reading);
    }
    const FrameResult result = system.Track(walk().images[i]);
    ASSERT_EQ(result.state, TrackingState::kTracking) << i;
    EXPECT_FALSE(result.inertial && result.inertial->estimate) << i;
  }
  EXPECT_LT(AbsolutePoseError(walk().truth, system.trajectory()).statistics.rmse, 0.02);
  EXPECT_FALSE(system.map().gravity_W());
}

TEST_F(SlamInertialTest, WithoutAnImuItTakesNoReadings) {
  SlamSystem system({.camera = SmallCamera()});
  EXPECT_THROW(system.AddImu(walk().readings.front()), InvalidArgument);
  EXPECT_FALSE(system.Track(walk().images[0]).inertial);
}

}  // namespace
}  // namespace highwall::slam_inertial_test
