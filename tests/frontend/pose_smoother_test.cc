#include "system/pose_smoother.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/so3.h>

#include "measured_recording.h"
#include "system/motion_noise.h"

namespace highwall::pose_smoother_test {
namespace {

using namespace smoothing_test;

TEST(MotionNoise, IsThatOfASimulatedMotionWhateverThePosesState) {
  // They state half the noise of the positions, and twice that of the rotations.
  const Recording recording = RandomMotion(3000, kHand, kPosition, kRotation,
                                           Information(0.5 * kPosition, 2.0 * kRotation), 1);
  const auto noise = EstimateMotionNoise(recording.measured);
  ASSERT_TRUE(noise);
  // Medians of 9000 squares have standard errors of 2 %; densities are differences of them.
  EXPECT_NEAR(noise->pose.position, 2.0, 0.1);
  EXPECT_NEAR(noise->pose.rotation, 0.5, 0.1);
  EXPECT_NEAR(noise->acceleration.linear, kHand.linear, 0.2 * kHand.linear);
  EXPECT_NEAR(noise->acceleration.angular, kHand.angular, 0.1 * kHand.angular);
}

TEST(MotionNoise, HardlyDependsOnSingleJumpsAndOnMissingFrames) {
  Recording recording = Hand(3000, 2);
  for (std::size_t i = 50; i < recording.measured.size(); i += 50) {
    MeasuredPose& pose = recording.measured[i];
    pose.T_WB = Pose(pose.T_WB.q(), pose.T_WB.p() + Eigen::Vector3d(0.1, 0, 0));
  }
  std::erase_if(recording.measured, [](const MeasuredPose& pose) { return pose.stamp % 7 == 0; });
  const auto noise = EstimateMotionNoise(recording.measured);
  ASSERT_TRUE(noise);
  EXPECT_NEAR(noise->pose.position, 1.0, 0.15);
  EXPECT_NEAR(noise->acceleration.angular, kHand.angular, 0.2 * kHand.angular);
}

TEST(MotionNoise, IsUnknownOfFewPosesOrOfPosesThatStateNothing) {
  Recording recording = Hand(30, 3);
  EXPECT_FALSE(EstimateMotionNoise(recording.measured));
  recording = Hand(100, 3);
  EXPECT_TRUE(EstimateMotionNoise(recording.measured));
  for (MeasuredPose& pose : recording.measured) pose.information.reset();
  EXPECT_FALSE(EstimateMotionNoise(recording.measured));
  for (MeasuredPose& pose : recording.measured) pose.information.emplace().setZero();
  EXPECT_FALSE(EstimateMotionNoise(recording.measured));
}

// A motion to and fro, once a second, of a camera with images `step` apart.
Recording ToAndFro(int frames, double step, unsigned seed) {
  std::mt19937 rng(seed);
  Recording recording;
  for (int i = 0; i < frames; ++i) {
    const double angle = 2.0 * M_PI * i * step;
    recording.Add(i * step,
                  Pose(so3::Exp({0, 0.15 * std::sin(angle), 0}), {0.1 * std::cos(angle), 0, 0}),
                  kPosition, kRotation, Information(kPosition, kRotation), rng);
  }
  return recording;
}

TEST(MotionNoise, IsUnknownOfAMotionThatReversesBetweenTheImages) {
  EXPECT_TRUE(EstimateMotionNoise(ToAndFro(300, 0.1, 4).measured));
  EXPECT_FALSE(EstimateMotionNoise(ToAndFro(300, 0.19, 4).measured));
}

TEST(PoseSmoother, AMotionThatReversesBetweenTheImagesStaysAsItIsMeasured) {
  for (const unsigned seed : {5U, 6U}) {
    const Recording recording = ToAndFro(300, 0.19, seed);
    for (const std::optional<SmoothedPose>& smoothed : SmoothPoses(recording.measured)) {
      EXPECT_FALSE(smoothed) << seed;
    }
  }
}

TEST(PoseSmoother, ReducesTheErrorOfAHandsMotion) {
  const Recording recording = Hand(600, 4);
  const std::vector<Pose> smoothed = Smooth(recording.measured);
  // A margin of a tenth to what this seed has.
  EXPECT_LT(PositionRmse(smoothed, recording.truth),
            0.67 * PositionRmse(Measured(recording), recording.truth));
  EXPECT_LT(RotationRmse(smoothed, recording.truth),
            0.95 * RotationRmse(Measured(recording), recording.truth));
}

TEST(PoseSmoother, TheFirstPoseOfAMapIsAsUncertainAsTheNext) {
  Recording recording = Hand(200, 5);
  const std::vector<Pose> expected = Smooth(recording.measured);
  recording.measured.front().information.reset();
  EXPECT_LT((Smooth(recording.measured).front().p() - expected.front().p()).norm(), 1e-9);
  // One that is off is taken off as a spike, by what holds it on one side, and bends nothing.
  MeasuredPose& first = recording.measured.front();
  first.T_WB = Pose(first.T_WB.q(), first.T_WB.p() + Eigen::Vector3d(0.05, 0, 0));
  const std::vector<Pose> smoothed = Smooth(recording.measured);
  EXPECT_LT((smoothed[0].p() - recording.truth[0].p()).norm(), 0.02);
  for (const std::size_t i : {3, 10}) {
    EXPECT_LT((smoothed[i].p() - expected[i].p()).norm(), 2e-3) << i;
  }
}

TEST(PoseSmoother, TheFirstPoseOfAMapIsAsUncertainAsTheNextThatAnImageMeasures) {
  Recording recording = Hand(200, 5);
  for (const std::size_t i : {1, 2}) recording.measured[i].information->setZero();
  const std::vector<Pose> expected = Smooth(recording.measured);
  recording.measured.front().information.reset();
  EXPECT_LT((Smooth(recording.measured).front().p() - expected.front().p()).norm(), 1e-9);
}

TEST(PoseSmoother, NeighboursReplaceAPoseThatItsImageDoesNotState) {
  Recording recording = Hand(400, 6);
  std::vector<std::size_t> blind;
  for (std::size_t i = 50; i < 350; i += 30) {
    MeasuredPose& pose = recording.measured[i];
    pose.information->setZero();
    pose.T_WB = Pose(pose.T_WB.q(), pose.T_WB.p() + Eigen::Vector3d(0.05, 0, 0));
    blind.push_back(i);
  }
  const std::vector<Pose> smoothed = Smooth(recording.measured);
  // Between frames of 2 mm at steps of 33 ms.
  for (const std::size_t i : blind) {
    EXPECT_LT((smoothed[i].p() - recording.truth[i].p()).norm(), 6e-3) << i;
  }
}

TEST(PoseSmoother, NeighboursHoldADirectionThatTheImageLeavesOpen) {
  Recording recording = Hand(400, 7);
  std::vector<std::size_t> weak;
  for (std::size_t i = 50; i < 350; i += 30) {
    MeasuredPose& pose = recording.measured[i];
    pose.information->row(0).setZero();  // along x of the camera
    pose.information->col(0).setZero();
    pose.T_WB = pose.T_WB * Pose::FromTangent({0.05, 0, 0}, {0, 0, 0});
    weak.push_back(i);
  }
  const std::vector<Pose> smoothed = Smooth(recording.measured);
  for (const std::size_t i : weak) {
    EXPECT_LT((smoothed[i].p() - recording.truth[i].p()).norm(), 6e-3) << i;
  }
}

TEST(PoseSmoother, ASpikeOfAPoseIsTakenOffWithoutItsNeighbours) {
  Recording recording = Hand(400, 8);
  const std::vector<Pose> without = Smooth(recording.measured);
  MeasuredPose& spike = recording.measured[200];
  spike.T_WB = Pose(spike.T_WB.q(), spike.T_WB.p() + Eigen::Vector3d(0.05, 0, 0));
  const std::vector<Pose> smoothed = Smooth(recording.measured);
  EXPECT_LT((smoothed[200].p() - recording.truth[200].p()).norm(), 0.01);
  for (const std::size_t i : {197, 203}) {
    EXPECT_LT((smoothed[i].p() - without[i].p()).norm(), 2e-3) << i;
  }
}

// Returns the pose `frames` after the last of those in [begin, end), as it is predicted from
// `start`.
std::optional<Pose> Predict(const Recording& recording, std::size_t begin, std::size_t end,
                            int frames, const Pose& start) {
  const auto first = recording.measured.begin();
  std::vector<MeasuredPose> poses(first + static_cast<std::ptrdiff_t>(begin),
                                  first + static_cast<std::ptrdiff_t>(end));
  const auto later = static_cast<Stamp>(std::llround(frames * kStep * 1e9));
  poses.push_back({poses.back().stamp + later, start, ImageInformation::Zero()});
  return PredictLastPose(poses);
}

TEST(PoseSmoother, PredictsBetterThanTheLastTwoPosesDo) {
  constexpr int kAhead = 3;
  const Recording recording = Hand(1500, 21);
  std::vector<Pose> by_two, by_all, truth;
  for (std::size_t i = 200; i + kAhead < 1500; i += 10) {
    const Pose& before = recording.measured[i - 2].T_WB;
    const Pose& last = recording.measured[i - 1].T_WB;
    const Eigen::Vector3d turn = kAhead * so3::Log(before.q().conjugate() * last.q());
    by_two.emplace_back(last.q() * so3::Exp(turn), last.p() + kAhead * (last.p() - before.p()));
    by_all.push_back(Predict(recording, i - 150, i, kAhead, by_two.back()).value());
    truth.push_back(recording.truth[i - 1 + kAhead]);
  }
  // A margin of a tenth to the worse of two draws: compilers draw the noise in another order.
  EXPECT_LT(PositionRmse(by_all, truth), 0.61 * PositionRmse(by_two, truth));
  // The hand's turns are hardly predictable, by whatever poses.
  EXPECT_LT(RotationRmse(by_all, truth), RotationRmse(by_two, truth));
}

TEST(PoseSmoother, APredictionTakesTheNewestPoseForTheBeginningOfAnotherMotion) {
  Recording recording = Hand(200, 22);
  const auto predicted_x = [&] {
    return Predict(recording, 0, 200, 1, recording.measured.back().T_WB).value().p().x();
  };
  const double before = predicted_x();
  MeasuredPose& newest = recording.measured.back();
  newest.T_WB = Pose(newest.T_WB.q(), newest.T_WB.p() + Eigen::Vector3d(0.05, 0, 0));
  // As a spike, which it would be if poses followed, less than half of it would remain.
  EXPECT_GT(predicted_x() - before, 0.04);
}

TEST(PoseSmoother, APredictionDoesNotReachAcrossAGap) {
  const Recording recording = Hand(200, 23);
  EXPECT_TRUE(Predict(recording, 0, 200, 14, Pose()));
  EXPECT_FALSE(Predict(recording, 0, 200, 16, Pose()));
  EXPECT_FALSE(Predict(recording, 0, 20, 1, Pose())) << "too few to know the motion";
}

TEST(PoseSmoother, NothingHoldsAcrossAGap) {
  Recording recording = Hand(400, 9);
  for (std::size_t i = 200; i < 400; ++i) {  // carried elsewhere for 2 s
    MeasuredPose& pose = recording.measured[i];
    pose.stamp += 2'000'000'000;
    pose.T_WB = Pose(pose.T_WB.q(), pose.T_WB.p() + Eigen::Vector3d(5, 0, 0));
    recording.truth[i] =
        Pose(recording.truth[i].q(), recording.truth[i].p() + Eigen::Vector3d(5, 0, 0));
  }
  const std::vector<Pose> smoothed = Smooth(recording.measured);
  for (const std::size_t i : {199, 200}) {
    EXPECT_LT((smoothed[i].p() - recording.truth[i].p()).norm(), 4 * kPosition) << i;
  }
}

TEST(PoseSmoother, WindowsOfALongRecordingDoNotShow) {
  const Recording recording = Hand(2300, 10);
  const StepErrors errors = ErrorsOfSteps(Smooth(recording.measured), recording.truth);
  EXPECT_LT(errors.at_seams, errors.elsewhere);
}

TEST(PoseSmoother, VelocitiesErrAsTheirCovarianceStates) {
  constexpr double kSmall = 5e-4;  // [m], [rad]: images that determine how the hand accelerates
  double of_linear = 0.0, of_angular = 0.0;
  for (unsigned seed = 40; seed < 46; ++seed) {
    const Recording recording =
        RandomMotion(1500, kHand, kSmall, kSmall, Information(kSmall, kSmall), seed);
    const VelocityErrors errors = ErrorsOfVelocities(recording, std::nullopt);
    EXPECT_EQ(errors.frames, 1500);
    of_linear += errors.of_linear / 6.0;
    of_angular += errors.of_angular / 6.0;
  }
  EXPECT_NEAR(of_linear, 3.0, 0.5);  // three degrees of freedom
  EXPECT_NEAR(of_angular, 3.0, 0.5);
}

TEST(PoseSmoother, FewPosesStayAsTheyAre) {
  EXPECT_TRUE(SmoothPoses({}).empty());
  const Recording recording = Hand(5, 11);
  const std::vector<Pose> smoothed = Smooth(recording.measured);
  ASSERT_EQ(smoothed.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ((smoothed[i].p() - recording.measured[i].T_WB.p()).norm(), 0.0);
  }
}

}  // namespace
}  // namespace highwall::pose_smoother_test
