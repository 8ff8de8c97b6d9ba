#include "system/pose_smoother.h"

#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/so3.h>

#include "support/imu_scene.h"
#include "system/motion_noise.h"

namespace highwall::pose_smoother_test {
namespace {

constexpr double kStep = 1.0 / 30.0;  // [s]

Eigen::Vector3d Normal(std::mt19937& rng, double sigma) {
  std::normal_distribution<double> normal(0.0, sigma);
  const double x = normal(rng), y = normal(rng), z = normal(rng);
  return {x, y, z};
}

ImageInformation Information(double position_sigma, double rotation_sigma) {
  Eigen::Matrix<float, 6, 1> diagonal;
  diagonal << Eigen::Vector3f::Constant(
      static_cast<float>(1.0 / (position_sigma * position_sigma))),
      Eigen::Vector3f::Constant(static_cast<float>(1.0 / (rotation_sigma * rotation_sigma)));
  return diagonal.asDiagonal();
}

using Vector6 = Eigen::Matrix<double, 6, 1>;

// A recording of a motion, as it is and as it is measured.
struct Recording {
  std::vector<Pose> truth;
  std::vector<Vector6> velocities;  // v_WB and omega_B of each, where they are known
  std::vector<MeasuredPose> measured;

  // Adds a frame. The measured pose has an error of both sigmas and states `information`.
  void Add(double seconds, const Pose& T_WC, double position_sigma, double rotation_sigma,
           const ImageInformation& information, std::mt19937& rng) {
    truth.push_back(T_WC);
    measured.push_back({static_cast<Stamp>(std::llround(seconds * 1e9)),
                        Pose(T_WC.q() * so3::Exp(Normal(rng, rotation_sigma)),
                             T_WC.p() + Normal(rng, position_sigma)),
                        information});
  }
};

// White noise on the accelerations, integrated in ten steps a frame.
Recording RandomMotion(int frames, const AccelerationNoise& noise, double position_sigma,
                       double rotation_sigma, const ImageInformation& information, unsigned seed) {
  std::mt19937 rng(seed);
  Recording recording;
  constexpr int kSteps = 10;
  const double dt = kStep / kSteps;
  Eigen::Vector3d p(1, 2, 3), v(0.2, 0, -0.1), w(0.3, -0.2, 0.1);
  Eigen::Quaterniond q = so3::Exp({0.3, -0.5, 1.0});
  for (int i = 0; i < frames; ++i) {
    recording.Add(i * kStep, Pose(q, p), position_sigma, rotation_sigma, information, rng);
    recording.velocities.emplace_back() << v, w;
    for (int k = 0; k < kSteps; ++k) {
      const Eigen::Vector3d dv = Normal(rng, std::sqrt(noise.linear * dt));
      const Eigen::Vector3d dw = Normal(rng, std::sqrt(noise.angular * dt));
      p += dt * (v + 0.5 * dv);
      q = (q * so3::Exp(dt * (w + 0.5 * dw))).normalized();
      v += dv;
      w += dw;
    }
  }
  return recording;
}

// The motion of a hand.
constexpr AccelerationNoise kHand{.linear = 0.02, .angular = 0.3};
constexpr double kPosition = 2e-3, kRotation = 2e-3;  // [m], [rad]

Recording Hand(int frames, unsigned seed) {
  return RandomMotion(frames, kHand, kPosition, kRotation, Information(kPosition, kRotation), seed);
}

double PositionRmse(const std::vector<Pose>& poses, const std::vector<Pose>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) sum += (poses[i].p() - truth[i].p()).squaredNorm();
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

double RotationRmse(const std::vector<Pose>& poses, const std::vector<Pose>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    sum += so3::Log(poses[i].q().conjugate() * truth[i].q()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

std::vector<Pose> Measured(const Recording& recording) {
  std::vector<Pose> poses;
  for (const MeasuredPose& pose : recording.measured) poses.push_back(pose.T_WB);
  return poses;
}

// The poses after smoothing; those that are not smoothed are as they were measured.
std::vector<Pose> Smooth(const std::vector<MeasuredPose>& measured,
                         const std::optional<Eigen::Vector3d>& gravity_W = std::nullopt) {
  const std::vector<std::optional<SmoothedPose>> smoothed = SmoothPoses(measured, gravity_W);
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    poses.push_back(smoothed[i] ? smoothed[i]->T_WB : measured[i].T_WB);
  }
  return poses;
}

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
  const std::vector<Pose> smoothed = Smooth(recording.measured);
  double worst = 0.0, at_seams = 0.0;
  for (std::size_t i = 1; i < smoothed.size(); ++i) {
    const double step = ((smoothed[i].p() - smoothed[i - 1].p()) -
                         (recording.truth[i].p() - recording.truth[i - 1].p()))
                            .norm();
    (i % 1000 == 0 ? at_seams : worst) = std::max(i % 1000 == 0 ? at_seams : worst, step);
  }
  EXPECT_LT(at_seams, worst);
}

// A body that moves at 30 Hz of images, each with errors of its own, and 200 Hz of readings, whose
// gyroscope and accelerometer have the noise of the densities that the readings state and a bias.
Recording WithReadings(int frames, unsigned seed) {
  std::mt19937 rng(seed);
  const SinusoidalMotion motion(2.0);
  ImuBias bias;
  bias << 0.02, -0.01, 0.015, 0.1, -0.05, 0.08;
  ReadingsBetween of_frame;
  of_frame.bias_sigma << Eigen::Vector3d::Constant(0.02), Eigen::Vector3d::Constant(0.1);
  const auto sample_at = [&](Stamp stamp) {
    constexpr double kRate = 210.0;
    ImuSample sample = WithBias({motion.SampleAt(stamp)}, bias).front();
    sample.gyroscope += Normal(rng, of_frame.noise.gyroscope * std::sqrt(kRate));
    sample.accelerometer += Normal(rng, of_frame.noise.accelerometer * std::sqrt(kRate));
    return sample;
  };
  Recording recording;
  ImuSample last = sample_at(0);
  for (int i = 0; i < frames; ++i) {
    const ImuState state = motion.StateAt(i * kStep);
    recording.Add(i * kStep, state.T_WB, kPosition, kRotation, Information(kPosition, kRotation),
                  rng);
    recording.velocities.emplace_back() << state.v_WB,
        motion.SampleAt(FromSeconds(i * kStep)).gyroscope;
    recording.measured.back().reference = KeyFrameId(i);
    if (i == 0) continue;
    ReadingsBetween readings = of_frame;
    readings.before = recording.measured[recording.measured.size() - 2].stamp;
    readings.samples = {last};
    for (int k = 1; k <= 7; ++k) {
      readings.samples.push_back(sample_at(FromSeconds((i - 1 + k / 7.0) * kStep)));
    }
    last = readings.samples.back();
    recording.measured.back().readings = std::make_shared<const ReadingsBetween>(readings);
  }
  return recording;
}

TEST(PoseSmoother, ReadingsOfAnImuReduceErrorsFurther) {
  Recording recording = WithReadings(300, 12);
  const std::vector<Pose> with = Smooth(recording.measured, kGravity);
  const std::vector<Pose> measured = Measured(recording);
  for (MeasuredPose& pose : recording.measured) pose.readings.reset();
  const std::vector<Pose> without = Smooth(recording.measured, kGravity);
  // A margin of a tenth to what this seed has.
  EXPECT_LT(PositionRmse(with, recording.truth), 0.6 * PositionRmse(without, recording.truth));
  EXPECT_LT(RotationRmse(with, recording.truth), 0.5 * RotationRmse(without, recording.truth));
  EXPECT_LT(PositionRmse(without, recording.truth), PositionRmse(measured, recording.truth));
}

TEST(PoseSmoother, ReadingsBridgeImagesThatStateNothing) {
  Recording recording = WithReadings(300, 13);
  for (std::size_t i = 140; i < 170; ++i) recording.measured[i].information->setZero();  // 1 s
  const std::vector<Pose> smoothed = Smooth(recording.measured, kGravity);
  for (std::size_t i = 140; i < 170; ++i) {
    EXPECT_LT((smoothed[i].p() - recording.truth[i].p()).norm(), 4e-3) << i;
  }
}

TEST(PoseNoise, IsThatOfTheImagesHoweverFastTheyMove) {
  Recording recording = WithReadings(600, 32);
  for (MeasuredPose& pose : recording.measured) {
    pose.information = Information(0.5 * kPosition, 2.0 * kRotation);
  }
  std::vector<ImuPreintegration> readings;
  for (std::size_t i = 1; i < recording.measured.size(); ++i) {
    const ReadingsBetween& between = *recording.measured[i].readings;
    readings.emplace_back(between.samples, ImuBias::Zero());
  }
  const auto noise = EstimatePoseNoise(recording.measured, readings, kGravity);
  ASSERT_TRUE(noise);
  // Medians of 1800 squares, neighbours of which share poses: standard errors of 4 %. The biases
  // are not known.
  EXPECT_NEAR(noise->position, 2.0, 0.25);
  EXPECT_NEAR(noise->rotation, 0.5, 0.06);
  const std::vector<MeasuredPose> few(recording.measured.begin(), recording.measured.begin() + 20);
  EXPECT_FALSE(EstimatePoseNoise(few, readings, kGravity));
}

// Changes the readings that end at a frame.
void Change(Recording* recording, std::size_t frame,
            const std::function<void(ReadingsBetween*)>& change) {
  auto& readings = recording->measured[frame].readings;
  ReadingsBetween changed = *readings;
  change(&changed);
  readings = std::make_shared<const ReadingsBetween>(std::move(changed));
}

// Poses may have been wrong when they were tracked, and have been refined since.
TEST(PoseSmoother, ContradictedReadingsHoldIfThePosesAgreeWithThem) {
  // The frames before the contradicted readings are too few to know their velocity.
  constexpr std::size_t kBefore = 10;
  double all = 0.0, with = 0.0, without = 0.0;  // sums of errors before these readings [m]
  for (unsigned seed = 15; seed < 25; ++seed) {
    Recording recording = WithReadings(60, seed);
    const auto error = [&] {
      const std::vector<Pose> poses = Smooth(recording.measured, kGravity);
      return PositionRmse({poses.begin(), poses.begin() + kBefore}, recording.truth);
    };
    all += error();
    Change(&recording, kBefore, [](ReadingsBetween* readings) { readings->contradicted = true; });
    with += error();
    recording.measured[kBefore].readings.reset();
    without += error();
  }
  // Of thirty recordings, by tens: 1.00 to 1.10, and 1.63 to 1.80.
  EXPECT_LT(with, 1.25 * all);
  EXPECT_GT(without, 1.4 * all);
}

TEST(PoseSmoother, ReadingsOfAnImpactOnTheSensorStateNothing) {
  constexpr std::size_t kImpact = 150;
  Recording recording = WithReadings(300, 16);
  Change(&recording, kImpact, [](ReadingsBetween* readings) {
    readings->contradicted = true;
    for (std::size_t k = 2; k < 5; ++k) {
      readings->samples[k].accelerometer += Eigen::Vector3d(20.0, -30.0, 10.0);
      readings->samples[k].gyroscope += Eigen::Vector3d(1.0, 2.0, -1.5);
    }
  });
  const std::vector<Pose> with = Smooth(recording.measured, kGravity);
  recording.measured[kImpact].readings.reset();
  const std::vector<Pose> without = Smooth(recording.measured, kGravity);
  // Nearly the same, since both halves share gravity's direction with them.
  EXPECT_LT(PositionRmse(with, recording.truth), 1.05 * PositionRmse(without, recording.truth));
  EXPECT_LT(RotationRmse(with, recording.truth), 1.05 * RotationRmse(without, recording.truth));
}

TEST(PoseSmoother, ReadingsAreNotUsedWithoutGravity) {
  Recording recording = WithReadings(200, 14);
  const std::vector<Pose> smoothed = Smooth(recording.measured);
  for (MeasuredPose& pose : recording.measured) pose.readings.reset();
  const std::vector<Pose> without = Smooth(recording.measured);
  for (std::size_t i = 0; i < smoothed.size(); ++i) {
    EXPECT_EQ((smoothed[i].p() - without[i].p()).norm(), 0.0) << i;
  }
}

// Of the velocities of a recording.
struct VelocityErrors {
  int frames = 0;
  double linear = 0.0, angular = 0.0;        // RMS [m/s], [rad/s]
  double of_linear = 0.0, of_angular = 0.0;  // means of e^T C^-1 e
};

VelocityErrors ErrorsOfVelocities(const Recording& recording,
                                  const std::optional<Eigen::Vector3d>& gravity_W) {
  const auto smoothed = SmoothPoses(recording.measured, gravity_W);
  VelocityErrors errors;
  for (std::size_t i = 0; i < smoothed.size(); ++i) {
    if (!smoothed[i] || !smoothed[i]->velocity) continue;
    const BodyVelocity& velocity = *smoothed[i]->velocity;
    const Eigen::Vector3d v = velocity.v_WB - recording.velocities[i].head<3>();
    const Eigen::Vector3d w = velocity.omega_B - recording.velocities[i].tail<3>();
    const Eigen::Matrix3d C_v = velocity.covariance.topLeftCorner<3, 3>();
    const Eigen::Matrix3d C_w = velocity.covariance.bottomRightCorner<3, 3>();
    ++errors.frames;
    errors.linear += v.squaredNorm();
    errors.angular += w.squaredNorm();
    errors.of_linear += v.dot(C_v.inverse() * v);
    errors.of_angular += w.dot(C_w.inverse() * w);
  }
  errors.linear = std::sqrt(errors.linear / errors.frames);
  errors.angular = std::sqrt(errors.angular / errors.frames);
  errors.of_linear /= errors.frames;
  errors.of_angular /= errors.frames;
  return errors;
}

TEST(PoseSmoother, VelocitiesErrAsTheirCovarianceStates) {
  double of_linear = 0.0, of_angular = 0.0;
  for (unsigned seed = 40; seed < 46; ++seed) {
    const VelocityErrors errors = ErrorsOfVelocities(Hand(1500, seed), std::nullopt);
    EXPECT_EQ(errors.frames, 1500);
    of_linear += errors.of_linear / 6.0;
    of_angular += errors.of_angular / 6.0;
  }
  // Three degrees of freedom. Single recordings have 2.3 to 6 and 2.8 to 3.4, since the densities
  // of the accelerations are estimated of them.
  EXPECT_NEAR(of_linear, 3.0, 1.5);
  EXPECT_NEAR(of_angular, 3.0, 0.5);
}

TEST(PoseSmoother, VelocitiesByAnImuErrAsTheirCovarianceStates) {
  double of_linear = 0.0, of_angular = 0.0;
  for (unsigned seed = 40; seed < 46; ++seed) {
    const VelocityErrors errors = ErrorsOfVelocities(WithReadings(400, seed), kGravity);
    EXPECT_EQ(errors.frames, 400);
    EXPECT_LT(errors.linear, 2e-3);
    of_linear += errors.of_linear / 6.0;
    of_angular += errors.of_angular / 6.0;
  }
  // Single ones have 2.3 to 3.6 and 2.8 to 3.0.
  EXPECT_NEAR(of_linear, 3.0, 0.9);
  EXPECT_NEAR(of_angular, 3.0, 0.3);
}

TEST(PoseSmoother, ImagesOfOneKeyframeStateAsMuchAsOne) {
  constexpr int kShared = 20;
  double by_keyframe = 0.0, alone = 0.0;  // sums of errors of velocities [m/s]
  for (unsigned seed = 27; seed < 32; ++seed) {
    Recording recording = WithReadings(400, seed);
    std::mt19937 rng(seed);
    Eigen::Vector3d error = Normal(rng, kPosition);
    for (std::size_t i = 0; i < recording.measured.size(); ++i) {
      if (i % kShared == 0) error = Normal(rng, kPosition);
      MeasuredPose& pose = recording.measured[i];
      const Pose& truth = recording.truth[i];
      pose.T_WB = Pose(truth.q() * so3::Exp(Normal(rng, 0.2 * kRotation)),
                       truth.p() + error + Normal(rng, 0.2 * kPosition));
    }
    alone += ErrorsOfVelocities(recording, kGravity).linear;
    for (MeasuredPose& pose : recording.measured) {
      pose.reference = KeyFrameId(pose.reference.value() / kShared);
    }
    by_keyframe += ErrorsOfVelocities(recording, kGravity).linear;
  }
  EXPECT_LT(by_keyframe, 0.8 * alone);
}

// Readings hold no pose over a minute, whatever images of one keyframe share.
TEST(PoseSmoother, AMinuteAtOneKeyframeIsHeldByItsImages) {
  Recording recording = WithReadings(1800, 33);
  for (MeasuredPose& pose : recording.measured) pose.reference = KeyFrameId(0);
  const double measured = PositionRmse(Measured(recording), recording.truth);
  // 0.24 here; 0.6 to 0.75 if all images state as much as one.
  EXPECT_LT(PositionRmse(Smooth(recording.measured, kGravity), recording.truth), 0.3 * measured);
}

TEST(PoseSmoother, BesideContradictedReadingsThereIsNoVelocity) {
  Recording recording = WithReadings(100, 26);
  Change(&recording, 50, [](ReadingsBetween* readings) { readings->contradicted = true; });
  const auto smoothed = SmoothPoses(recording.measured, kGravity);
  for (std::size_t i = 0; i < smoothed.size(); ++i) {
    EXPECT_EQ(smoothed[i].value().velocity.has_value(), i != 49 && i != 50) << i;
  }
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
