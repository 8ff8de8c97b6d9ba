#include "system/frame_trajectories.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/so3.h>

#include "support/imu_scene.h"
#include "system/pose_smoother.h"

namespace highwall::frame_trajectories_test {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

Eigen::Vector3d Random(std::mt19937& rng, double range) {
  std::uniform_real_distribution<double> uniform(-range, range);
  const double x = uniform(rng), y = uniform(rng), z = uniform(rng);
  return {x, y, z};
}

// Two worlds, each with a keyframe and 60 frames, alternately, with noise of 2 mm and 2 mrad.
struct TwoWorlds {
  Map map;
  std::vector<KeyFrameId> keyframes;
  std::vector<SubmapId> submaps;
  FrameTrajectories trajectories;

  TwoWorlds() {
    std::mt19937 rng(1);
    const auto features = std::make_shared<const FrameFeatures>();
    for (int world = 0; world < 2; ++world) {
      submaps.push_back(world == 0 ? kFirstSubmap : map.AddSubmap());
      const Pose T_WC = Pose::FromTangent(Random(rng, 3.0), Random(rng, 1.0));
      keyframes.push_back(map.AddKeyFrame({world, world, features}, T_WC, submaps.back()).id);
    }
    for (int i = 0; i < 120; ++i) Add(i, rng);
  }

  void Add(int i, std::mt19937& rng) {
    const auto world = static_cast<std::size_t>(i % 2);
    const Pose T_WC = Pose::FromTangent({0.01 * i, 0, 0}, {0, 0.01 * i, 0}) *
                      Pose::FromTangent(Random(rng, 2e-3), Random(rng, 2e-3));
    const ImageInformation information = 1e6F * ImageInformation::Identity();
    trajectories.Add({i * 16'000'000LL, AnchoredPose::At(map, keyframes[world], T_WC), information},
                     submaps[world]);
  }

  SubmapTrajectory World(std::size_t world) const {
    for (const SubmapTrajectory& submap : trajectories.ByWorld(map)) {
      if (submap.submap == submaps[world]) return submap;
    }
    return {};
  }
  Trajectory Of(std::size_t world) const { return World(world).frames; }
  std::vector<FrameVelocity> VelocitiesOf(std::size_t world) const {
    return World(world).velocities;
  }

  std::vector<MeasuredPose> Measured(std::size_t world) const {
    std::vector<MeasuredPose> measured;
    for (const PosedFrame& frame : trajectories.frames()) {
      if (frame.pose.reference != keyframes[world]) continue;
      measured.push_back({frame.stamp, frame.pose.T_WC(map), frame.information});
    }
    return measured;
  }
};

void ExpectNear(const Trajectory& frames,
                const std::vector<std::optional<SmoothedPose>>& expected) {
  ASSERT_EQ(frames.size(), expected.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    // Rounding of the anchored pose.
    EXPECT_LT((frames[i].pose.p() - expected[i].value().T_WB.p()).norm(), 1e-12) << i;
  }
}

TEST(ImageInformation, IsThatOfTheSameStepInTheCamera) {
  std::mt19937 rng(2);
  for (int i = 0; i < 20; ++i) {
    Matrix6 root;
    for (int k = 0; k < 6; ++k) root.col(k) << Random(rng, 3.0), Random(rng, 3.0);
    const Matrix6 information = root.transpose() * root;
    const Pose T_WC = Pose::FromTangent(Random(rng, 5.0), Random(rng, 1.7));
    Eigen::Matrix<double, 6, 1> in_world, in_camera;
    const Eigen::Vector3d rotation = Random(rng, 1.0);
    in_camera << Random(rng, 1.0), rotation;
    in_world << T_WC.R() * in_camera.head<3>(), rotation;
    const double expected = in_world.dot(information * in_world);
    const Matrix6 of_camera = InformationInCamera(information, T_WC).cast<double>();
    EXPECT_NEAR(in_camera.dot(of_camera * in_camera), expected, 1e-4) << "rounding to floats";
  }
}

TEST(ImageInformation, OfABodyIsThatOfTheStepOfItsCamera) {
  std::mt19937 rng(4);
  for (int i = 0; i < 20; ++i) {
    Matrix6 root;
    for (int k = 0; k < 6; ++k) root.col(k) << Random(rng, 3.0), Random(rng, 3.0);
    const ImageInformation of_camera = (root.transpose() * root).cast<float>();
    const Pose T_BC = Pose::FromTangent(Random(rng, 1.0), Random(rng, 1.7));
    constexpr double kStep = 1e-5;  // of the body, in B: second order is 1e-5 of it
    const Eigen::Vector3d translation = Random(rng, 1.0), rotation = Random(rng, 1.0);
    const Pose T_BB =
        Pose(so3::Exp(kStep * rotation), kStep * translation);  // from the body before to after
    const Pose T_CC = T_BC.Inverse() * T_BB * T_BC;
    Eigen::Matrix<double, 6, 1> of_body, step;
    of_body << translation, rotation;
    step << T_CC.p() / kStep, so3::Log(T_CC.q()) / kStep;
    const double expected = step.dot(of_camera.cast<double>() * step);
    const Matrix6 in_body = InformationOfBody(of_camera, T_BC).cast<double>();
    EXPECT_NEAR(of_body.dot(in_body * of_body), expected, 1e-3 * (1.0 + expected)) << i;
  }
}

TEST(FrameTrajectories, ThePoseOfAnImuThatIsNotUsedDoesNotCount) {
  TwoWorlds without, with;
  without.trajectories.Smooth(without.map, std::nullopt);
  with.trajectories.Smooth(with.map, Pose::FromTangent({5, 0, 0}, {0, 1, 0}));
  const Trajectory expected = without.Of(0), frames = with.Of(0);
  ASSERT_EQ(frames.size(), expected.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ((frames[i].pose.p() - expected[i].pose.p()).norm(), 0.0) << i;
  }
}

TEST(FrameTrajectories, EachWorldIsSmoothedByItself) {
  TwoWorlds worlds;
  worlds.trajectories.Smooth(worlds.map, std::nullopt);
  for (const std::size_t world : {0U, 1U}) {
    const std::vector<MeasuredPose> measured = worlds.Measured(world);
    const Trajectory frames = worlds.Of(world);
    ExpectNear(frames, SmoothPoses(measured));
    EXPECT_GT((frames[30].pose.p() - measured[30].T_WB.p()).norm(), 1e-5);
  }
}

TEST(FrameTrajectories, FramesThatAreFoundLaterTakeTheirPlaceByTime) {
  TwoWorlds worlds;
  worlds.trajectories.Smooth(worlds.map, std::nullopt);
  const std::size_t before = worlds.Of(0).size();
  const auto found_at = [&](Stamp stamp, std::size_t world) {
    PosedFrame found{stamp, AnchoredPose::At(worlds.map, worlds.keyframes[world], Pose())};
    found.information = 1e6F * ImageInformation::Identity();
    return found;
  };
  worlds.trajectories.Insert({found_at(5, 0), found_at(40'000'000, 1), found_at(1LL << 40, 0)},
                             worlds.map);
  const std::vector<PosedFrame>& frames = worlds.trajectories.frames();
  EXPECT_TRUE(std::ranges::is_sorted(frames, {}, &PosedFrame::stamp));
  EXPECT_EQ(frames[1].stamp, 5);
  EXPECT_EQ(frames.back().stamp, 1LL << 40);
  EXPECT_EQ(worlds.Of(0).size(), before + 2);
  EXPECT_EQ(worlds.trajectories.LargestWorld(worlds.map), worlds.submaps[0]);
  // Poses smoothed before are not those of the frames that have their numbers now.
  EXPECT_LT(worlds.Of(0)[1].pose.p().norm(), 1e-12);
}

TEST(FrameTrajectories, SmoothingAgainStartsFromTheMeasuredPoses) {
  TwoWorlds worlds;
  worlds.trajectories.Smooth(worlds.map, std::nullopt);
  std::mt19937 rng(3);
  for (int i = 120; i < 140; ++i) worlds.Add(i, rng);
  // The new frames are as measured.
  const std::vector<MeasuredPose> measured = worlds.Measured(0);
  EXPECT_LT((worlds.Of(0).back().pose.p() - measured.back().T_WB.p()).norm(), 1e-12);
  worlds.trajectories.Smooth(worlds.map, std::nullopt);
  ExpectNear(worlds.Of(0), SmoothPoses(measured));
}

// From frame 20 to 39 each second image repeats the one before, and the others are late by one.
TEST(FrameTrajectories, PosesOfLateImagesHoldTheTrajectoryAtTheirTime) {
  constexpr Stamp kInterval = 33'000'000;
  constexpr double kFar = 0.01;  // [m] of an extrapolated pose
  Map map;
  const auto features = std::make_shared<const FrameFeatures>();
  const KeyFrameId keyframe = map.AddKeyFrame({0, 0, features}, Pose(), kFirstSubmap).id;
  const auto truth = [](double i) { return Pose::FromTangent({0.01 * i, 0, 0}, {0, 0.01 * i, 0}); };
  std::mt19937 rng(5);
  FrameTrajectories trajectories;
  for (int i = 0; i < 60; ++i) {
    const bool is_dark = i >= 20 && i < 40, is_repeated = is_dark && i % 2 == 1;
    const Pose noise = Pose::FromTangent(Random(rng, 2e-4), Random(rng, 2e-4));
    PosedFrame frame{.stamp = i * kInterval,
                     .pose = AnchoredPose::At(map, keyframe, truth(i) * noise),
                     .information = 1e8F * ImageInformation::Identity()};
    if (is_dark) {
      frame.pose =
          AnchoredPose::At(map, keyframe, truth(i) * Pose::FromTangent({0, kFar, 0}, {0, 0, 0}));
      frame.information = ImageInformation::Zero();
    }
    if (is_dark && !is_repeated) {
      frame.delay = kInterval;
      frame.by_image = AnchoredPose::At(map, keyframe, truth(i - 1) * noise);
      frame.information = 1e8F * ImageInformation::Identity();
    }
    trajectories.Add(frame, kFirstSubmap);
  }
  trajectories.Smooth(map, std::nullopt);
  const Trajectory frames = trajectories.ByWorld(map).front().frames;
  ASSERT_EQ(frames.size(), 60u);
  for (int i = 0; i < 60; ++i) {
    const StampedPose& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.stamp, i * kInterval);
    // Five standard deviations of an image's noise; without its time an image is 10 mm off.
    EXPECT_LT((frame.pose.p() - truth(i).p()).norm(), 1e-3) << i;
  }
}

TEST(FrameTrajectories, ThePoseAtTheStampOfALateImageIsPredictedInItsWorld) {
  TwoWorlds worlds;
  constexpr Stamp kDelay = 64'000'000;  // of the image: of the frame before in its world, and later
  const auto truth = [](int i) { return Pose::FromTangent({0.01 * i, 0, 0}, {0, 0.01 * i, 0}); };
  PosedFrame late{.stamp = 124 * 16'000'000LL,
                  .pose = AnchoredPose::At(worlds.map, worlds.keyframes[0], Pose()),
                  .information = 1e6F * ImageInformation::Identity(),
                  .by_image = AnchoredPose::At(worlds.map, worlds.keyframes[0], truth(120)),
                  .delay = kDelay};
  worlds.trajectories.Add(late, worlds.submaps[0]);
  const std::optional<Pose> predicted = worlds.trajectories.PredictNewest(worlds.map);
  ASSERT_TRUE(predicted);
  // Poses with noise of 2 mm predict 40 mm; the other world has another place for them.
  EXPECT_LT((predicted->p() - truth(124).p()).norm(), 3e-3);
}

// Of a body with readings of an IMU.
TEST(FrameTrajectories, VelocitiesAreThoseOfTheCamera) {
  constexpr int kFrames = 120;
  constexpr double kInterval = 0.03;  // [s]
  const Pose T_BC = Pose::FromTangent({0.2, -0.1, 0.3}, {0.4, -1.0, 0.7});
  const SinusoidalMotion motion(1.5);
  Map map;
  const auto features = std::make_shared<const FrameFeatures>();
  const KeyFrameId keyframe =
      map.AddKeyFrame({0, 0, features}, Pose::FromTangent({1, 2, 3}, {0.1, 0.2, 0.3}), kFirstSubmap)
          .id;
  map.SetGravity(kGravity);
  FrameTrajectories trajectories;
  std::mt19937 rng(6);
  std::vector<ImuSample> samples = motion.Samples(1.0 / 0.003, kFrames * kInterval);
  for (int i = 0; i < kFrames; ++i) {
    const Pose T_WB = motion.StateAt(i * kInterval).T_WB *
                      Pose::FromTangent(Random(rng, 1e-4), Random(rng, 1e-4));
    PosedFrame frame{.stamp = FromSeconds(i * kInterval),
                     .pose = AnchoredPose::At(map, keyframe, T_WB * T_BC),
                     .information = 3e8F * ImageInformation::Identity()};
    if (i > 0) {
      auto readings = std::make_shared<ReadingsBetween>();
      readings->before = FromSeconds((i - 1) * kInterval);
      readings->samples.assign(samples.begin() + 10 * (i - 1), samples.begin() + 10 * i + 1);
      readings->bias_sigma.setConstant(1e-3);
      frame.readings = readings;
    }
    trajectories.Add(frame, kFirstSubmap);
  }
  EXPECT_TRUE(trajectories.ByWorld(map).front().velocities.empty());
  trajectories.Smooth(map, T_BC);
  const std::vector<FrameVelocity> velocities = trajectories.ByWorld(map).front().velocities;
  ASSERT_EQ(velocities.size(), kFrames);
  for (std::size_t i = 0; i < kFrames; ++i) {
    const double t = static_cast<double>(i) * kInterval;
    const ImuState body = motion.StateAt(t);
    const Eigen::Vector3d omega_B = motion.SampleAt(FromSeconds(t)).gyroscope;
    const Eigen::Vector3d v_WC = body.v_WB + body.T_WB.R() * omega_B.cross(T_BC.p());
    EXPECT_EQ(velocities[i].stamp, FromSeconds(t));
    // A millimetre a second; without the lever arm they would differ by decimetres.
    EXPECT_LT((velocities[i].v_WC - v_WC).norm(), 2e-3) << i;
    EXPECT_LT((velocities[i].omega_C - T_BC.R().transpose() * omega_B).norm(), 1e-3) << i;
  }
}

TEST(FrameTrajectories, VelocitiesTurnWithTheWorldOfTheirKeyframe) {
  TwoWorlds worlds;
  worlds.trajectories.Smooth(worlds.map, std::nullopt);
  const std::vector<FrameVelocity> before = worlds.VelocitiesOf(1);
  const Pose T = Pose::FromTangent({1, 2, 3}, {0.3, -0.2, 0.1});
  worlds.map.Transform(T, worlds.submaps[1]);
  const std::vector<FrameVelocity> after = worlds.VelocitiesOf(1);
  ASSERT_EQ(after.size(), 60u);
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_LT((after[i].v_WC - T.R() * before[i].v_WC).norm(), 1e-12) << i;
    EXPECT_LT((after[i].omega_C - before[i].omega_C).norm(), 1e-12) << i;
    Matrix6 J = Matrix6::Identity();
    J.topLeftCorner<3, 3>() = T.R();
    const Matrix6 expected = J * before[i].covariance * J.transpose();
    EXPECT_LT((after[i].covariance - expected).norm(), 1e-12 * expected.norm()) << i;
  }
}

TEST(FrameTrajectories, SmoothedPosesFollowTheirKeyframes) {
  TwoWorlds worlds;
  worlds.trajectories.Smooth(worlds.map, std::nullopt);
  const Trajectory before = worlds.Of(1);
  const Pose T = Pose::FromTangent({1, 2, 3}, {0.3, -0.2, 0.1});
  worlds.map.Transform(T, worlds.submaps[1]);
  const Trajectory after = worlds.Of(1);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_LT((after[i].pose.p() - (T * before[i].pose).p()).norm(), 1e-12) << i;
  }
}

}  // namespace
}  // namespace highwall::frame_trajectories_test
