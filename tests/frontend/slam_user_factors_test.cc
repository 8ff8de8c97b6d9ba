// SlamSystem with user factors: a drive along a road that never returns, with positions in a
// reference frame of their own. Takes some ten seconds.
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include <ceres/loss_function.h>
#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/relative_pose.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/factors/position.h>
#include <highwall/frontend/system/slam_system.h>
#include <simulate/scenes/drive.h>

#include "support/rendered_walk.h"

namespace highwall::slam_user_factors_test {
namespace {

constexpr double kSigma = 0.02;  // [m] of a position, by axis
// [m] RMS, twice the noise of one position. Neighbouring positions average the noise, also of the
// outliers of metres, one in twenty; but if only a gravity prior limits the roll of the frame about
// a straight path, the camera is off to the side.
constexpr double kBound = 2.0 * 1.7321 * kSigma;
const Pose kT_GW = Pose::FromTangent({4.5e5, 5.4e6, 400}, {0, 0, 2.0});

class SlamUserFactorsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    simulate::SimulationOptions options = simulate::FieldTestOptions();
    options.seed = 3;
    options.duration = 20.0;  // 37 m
    options.fps = 10.0;
    options.camera = simulate::Scaled(options.camera, 0.4);
    options.exposure.mode = simulate::ExposureMode::kIdeal;
    simulation_ = std::make_unique<simulate::Simulation>(simulate::SimulateDrive(options));
    drive_ = std::make_unique<testing::RenderedWalk>(testing::Render(*simulation_));
  }
  static void TearDownTestSuite() {
    drive_.reset();
    simulation_.reset();
  }

  static SlamSystem MakeSystem(bool synchronous = true) {
    RgbdSensor sensor{.camera = simulation_->options().camera};
    sensor.depth_noise = simulation_->options().sensor.Noise();
    sensor.max_depth = simulation_->options().sensor.max_depth;
    SlamOptions options;
    options.frame.use_lines = false;  // to save time
    return SlamSystem(sensor, synchronous ? Deterministic(options) : options);
  }

  // Adds the positions with stamps in (from, until], three a second and none at a frame; one in
  // twenty, from the third on, is off by metres.
  static void AddPositions(ReferenceFrameId frame, Stamp from, Stamp until, SlamSystem& slam) {
    static const Eigen::Vector3d kAntenna(0.1, -0.5, 0.2);
    const Stamp first = drive_->images.front().stamp + FromSeconds(0.03);
    std::mt19937 rng(11);
    std::normal_distribution<double> normal(0.0, kSigma);
    for (int i = 0; i < 59; ++i) {
      const Stamp stamp = first + FromSeconds(i / 3.0);
      const double x = normal(rng), y = normal(rng), z = normal(rng);
      if (stamp <= from || stamp > until) continue;
      Eigen::Vector3d p_G =
          kT_GW * (simulation_->T_WC(stamp) * kAntenna) + Eigen::Vector3d(x, y, z);
      if (i % 20 == 2) p_G.x() += 5.0;
      slam.AddFactor(
          {{stamp},
           frame,
           std::make_shared<PositionFactor>(p_G, kAntenna, Eigen::Matrix3d::Identity() / kSigma),
           std::make_shared<ceres::HuberLoss>(3.0)});
    }
  }

  static double Rmse(const SlamSystem& slam) {
    return AbsolutePoseError(drive_->truth, slam.trajectory()).statistics.rmse;
  }

  static double Drive(SlamSystem& slam, std::optional<ReferenceFrameId> frame = std::nullopt) {
    Stamp last = 0;
    for (const RgbdImage& image : drive_->images) {
      if (frame) AddPositions(*frame, last, image.stamp, slam);
      last = image.stamp;
      EXPECT_EQ(slam.Track(image).state, TrackingState::kTracking);
    }
    slam.Finish();
    return Rmse(slam);
  }

  // Returns the RMS distance [m] of the trajectory from the truth, both in the frame of the
  // positions.
  static double ErrorInFrame(const SlamSystem& slam, ReferenceFrameId frame) {
    const std::optional<Pose> T_GW = slam.T_FW(frame);
    if (!T_GW) return std::numeric_limits<double>::infinity();
    const Trajectory trajectory = slam.trajectory();
    double sum = 0.0;
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
      sum += (*T_GW * trajectory[i].pose.p() - kT_GW * drive_->truth[i].pose.p()).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(trajectory.size()));
  }

  static std::unique_ptr<const simulate::Simulation> simulation_;
  static std::unique_ptr<const testing::RenderedWalk> drive_;
};

std::unique_ptr<const simulate::Simulation> SlamUserFactorsTest::simulation_;
std::unique_ptr<const testing::RenderedWalk> SlamUserFactorsTest::drive_;

TEST_F(SlamUserFactorsTest, PositionsKeepALongPathFromDrifting) {
  SlamSystem plain = MakeSystem(), with = MakeSystem(), again = MakeSystem();
  const double drift = Drive(plain);
  int reported_maps = 0;
  with.SetCallbacks({.on_map = [&](const Map&) { ++reported_maps; }});
  const ReferenceFrameId frame = with.AddReferenceFrame();
  const double held = Drive(with, frame);
  EXPECT_EQ(with.factor_counts().waiting, 0u);
  EXPECT_EQ(with.factor_counts().attached, 59u);
  EXPECT_EQ(with.factor_counts().refused, 0u);
  EXPECT_GE(reported_maps, 2);
  // 37 m drift by 6 cm; the remaining errors are the noise of positions and depth.
  EXPECT_LT(held, 0.3 * drift);
  EXPECT_LT(ErrorInFrame(with, frame), 0.5 * kBound);
  Drive(again, again.AddReferenceFrame());
  EXPECT_EQ(again.trajectory().back().pose.Matrix(), with.trajectory().back().pose.Matrix())
      << "bit for bit";
}

TEST_F(SlamUserFactorsTest, InTheBackgroundOrAllAtTheEndTheyDoSoToo) {
  SlamSystem live = MakeSystem(/*synchronous=*/false);
  const ReferenceFrameId frame = live.AddReferenceFrame();
  Drive(live, frame);
  EXPECT_LT(ErrorInFrame(live, frame), kBound);

  SlamSystem late = MakeSystem();
  const ReferenceFrameId given_late = late.AddReferenceFrame();
  for (std::size_t i = 0; i + 1 < drive_->images.size(); ++i) late.Track(drive_->images[i]);
  AddPositions(given_late, 0, drive_->images.back().stamp, late);
  EXPECT_EQ(late.factor_counts().waiting, 59u);
  late.Track(drive_->images.back());
  late.Finish();
  EXPECT_LT(ErrorInFrame(late, given_late), kBound);
  // A joint adjustment of everything preserves the constraints of the positions.
  EXPECT_GT(late.AdjustAll().user_factors, 40);
  EXPECT_LT(ErrorInFrame(late, given_late), kBound);
}

TEST_F(SlamUserFactorsTest, MotionBetweenStampsNeedsNoFrame) {
  // Wheel odometry that measures the motion of every second to a millimetre and a tenth of a
  // degree.
  Eigen::Matrix<double, 6, 6> W = Eigen::Matrix<double, 6, 6>::Identity() / 0.001;
  W.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() / 0.002;
  SlamSystem plain = MakeSystem(), with = MakeSystem();
  for (std::size_t i = 10; i < drive_->truth.size(); i += 10) {
    const StampedPose &a = drive_->truth[i - 10], &b = drive_->truth[i];
    with.AddFactor(
        {{a.stamp, b.stamp}, kNoId, std::make_shared<RelativePose>(a.pose.Inverse() * b.pose, W)});
  }
  const double drift = Drive(plain);
  EXPECT_LT(Drive(with), 0.7 * drift);
  EXPECT_EQ(with.factor_counts().attached, 19u);
}

TEST_F(SlamUserFactorsTest, FactorsAddedAfterTheLastFrameTakePart) {
  constexpr std::size_t kFrames = 30;  // 3 s
  SlamSystem slam = MakeSystem();
  for (std::size_t i = 0; i < kFrames; ++i) slam.Track(drive_->images[i]);
  const auto measure = [&](std::size_t from, std::size_t to) {
    const StampedPose &a = drive_->truth[from], &b = drive_->truth[to];
    const Eigen::Matrix<double, 6, 6> W = Eigen::Matrix<double, 6, 6>::Identity() / 0.002;
    slam.AddFactor(
        {{a.stamp, b.stamp}, kNoId, std::make_shared<RelativePose>(a.pose.Inverse() * b.pose, W)});
  };
  measure(0, kFrames - 1);
  measure(0, kFrames);  // its last stamp is after the last frame
  EXPECT_EQ(slam.factor_counts().waiting, 2u);
  slam.Finish();
  EXPECT_EQ(slam.factor_counts().waiting, 1u);
  EXPECT_EQ(slam.factor_counts().attached, 1u);
  EXPECT_EQ(slam.map().factors().all().size(), 1u);
  measure(1, kFrames - 2);
  EXPECT_EQ(slam.AdjustAll().user_factors, 2);
  EXPECT_EQ(slam.factor_counts().attached, 2u);
}

TEST_F(SlamUserFactorsTest, RefusesFactorsThatDoNotMatchTheirFrame) {
  SlamSystem slam = MakeSystem();
  const auto cost = std::make_shared<PositionFactor>(
      Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity());
  EXPECT_THROW(slam.AddFactor({{1}, ReferenceFrameId(0), cost}), InvalidArgument);
  const ReferenceFrameId frame = slam.AddReferenceFrame();
  EXPECT_NO_THROW(slam.AddFactor({{1}, frame, cost}));
  EXPECT_THROW(slam.AddFactor({{1}, kNoId, cost}), InvalidArgument);
  EXPECT_FALSE(slam.T_FW(frame));
  slam.Track(drive_->images[0]);
  EXPECT_EQ(slam.factor_counts().refused, 1u) << "before the first frame";
}

}  // namespace
}  // namespace highwall::slam_user_factors_test
