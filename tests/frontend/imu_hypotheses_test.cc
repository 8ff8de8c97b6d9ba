#include "sensor/imu_hypotheses.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "inertial_scene.h"

namespace highwall::imu_hypotheses_test {
namespace {

using testing::InertialScene;
using testing::InertialSceneOptions;

// Readings and images at 30 Hz of a generated motion, and what the calibration says.
struct Recording {
  Trajectory poses;
  std::vector<ImuSample> readings;
  ImuCalibration calibration;
};

Recording Record(unsigned seed, double motion = 1.0, double duration = 5.0) {
  InertialSceneOptions options;
  options.seed = seed;
  options.motion = motion;
  options.bias << 0.004, -0.005, 0.003, 0.1, -0.1, 0.1;
  // Where the motion begins differs from draw to draw.
  const double begin = 1.0 + 0.7 * seed;
  InertialScene scene(options);
  Recording recording;
  recording.calibration = scene.calibration();
  recording.readings = scene.Readings(begin - 0.7, begin + duration + 0.7);
  for (int i = 0; i <= std::lround(30.0 * duration); ++i) {
    const double t = begin + i / 30.0;
    recording.poses.push_back({FromSeconds(t), scene.See(t).T_WC});
  }
  return recording;
}

ImuJudgement JudgementOf(const Recording& recording) {
  return JudgeImu(recording.poses, recording.readings, recording.calibration);
}

void ForEachReading(Recording& recording, const std::function<void(ImuSample&)>& change) {
  for (ImuSample& reading : recording.readings) change(reading);
}

void TurnMount(Recording& recording, const Eigen::Vector3d& by) {
  const Pose& T_BC = recording.calibration.T_BC;
  recording.calibration.T_BC = Pose(T_BC.q() * so3::Exp(by), T_BC.p());
}

// rate: of the clock of the IMU, over that of the images.
void StretchStamps(Recording& recording, double rate) {
  const Stamp first = recording.readings.front().stamp;
  for (ImuSample& reading : recording.readings) {
    reading.stamp = first + std::llround(rate * static_cast<double>(reading.stamp - first));
  }
}

constexpr unsigned kSeeds = 6;
constexpr double kDegree = std::numbers::pi / 180.0;

TEST(JudgeImu, FindsNothingWithinTheTolerancesOfACalibration) {
  const std::vector<std::pair<const char*, std::function<void(Recording&)>>> deviations = {
      {"none", [](Recording&) {}},
      {"2 deg",
       [](Recording& r) {
         TurnMount(r, {2.0 * kDegree, 0.0, 0.0});
       }},
      {"20 ms",
       [](Recording& r) { ForEachReading(r, [](ImuSample& s) { s.stamp += 20'000'000; }); }},
      {"2 % of depth",
       [](Recording& r) {
         for (StampedPose& p : r.poses) p.pose = Pose(p.pose.q(), 1.02 * p.pose.p());
       }},
      {"2 % of the gyroscope",
       [](Recording& r) { ForEachReading(r, [](ImuSample& s) { s.gyroscope *= 1.02; }); }},
  };
  for (const auto& [name, change] : deviations) {
    // 90 draws in all: a rate of false alarms of 3 % is found with a probability of 95 %.
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      for (const double motion : {0.05, 0.3, 1.0}) {
        Recording recording = Record(seed, motion, 3.0);
        change(recording);
        const ImuJudgement judgement = JudgementOf(recording);
        EXPECT_LT(judgement.agreement, ImuAgreement::kUnconfirmed)
            << name << ", seed " << seed << ", motion " << motion;
      }
    }
  }
}

TEST(JudgeImu, ConfirmsARightConfigurationInMotion) {
  EXPECT_EQ(JudgementOf(Record(1)).agreement, ImuAgreement::kConsistent);
}

// An image determines a rotation about what it sees poorly, so that its errors of rotation and
// position fit a lever arm as long as the depth.
TEST(JudgeImu, FindsNothingWhereImagesConfuseRotationAndTranslation) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    for (const double sigma : {5e-4, 1e-3, 2e-3}) {
      Recording recording = Record(seed, 0.1, 10.0);
      const Eigen::Vector3d seen_C(0.0, 0.0, 8.0);
      std::mt19937 random(seed);
      std::normal_distribution<double> error(0.0, sigma);
      for (StampedPose& p : recording.poses) {
        const Eigen::Quaterniond turn =
            so3::Exp({error(random), error(random), 0.1 * error(random)});
        p.pose = p.pose * Pose(turn, seen_C - turn * seen_C);
      }
      const ImuJudgement judgement = JudgementOf(recording);
      EXPECT_LT(judgement.agreement, ImuAgreement::kUnconfirmed) << seed << " " << sigma;
    }
  }
}

TEST(JudgeImu, IsUndecidedAtRest) {
  Recording recording = Record(1, 0.0);
  recording.calibration.T_BC = recording.calibration.T_BC.Inverse();
  EXPECT_EQ(JudgementOf(recording).agreement, ImuAgreement::kUndecided);
}

TEST(JudgeImu, IsUndecidedWithoutReadings) {
  Recording recording = Record(1);
  recording.readings.clear();
  EXPECT_EQ(JudgementOf(recording).agreement, ImuAgreement::kUndecided);
}

TEST(JudgeImu, BlamesTheDepthAndNotTheImuForAWrongScaleOfTheImages) {
  Recording recording = Record(1);
  for (StampedPose& p : recording.poses) p.pose = Pose(p.pose.q(), 5.0 * p.pose.p());
  const ImuJudgement judgement = JudgementOf(recording);
  ASSERT_TRUE(judgement.finding);
  EXPECT_EQ(judgement.finding->fault, SensorFault::kDepthScale) << judgement.finding->text;
  EXPECT_NE(judgement.finding->text.find("depth is 0.2"), std::string::npos)
      << judgement.finding->text;
}

TEST(JudgeImu, BlamesTheUnitOfTheAccelerometerWhereGravityIsWrong) {
  Recording recording = Record(1);
  ForEachReading(recording, [](ImuSample& s) { s.accelerometer *= 2.0; });
  const ImuJudgement judgement = JudgementOf(recording);
  ASSERT_TRUE(judgement.finding);
  EXPECT_EQ(judgement.finding->fault, SensorFault::kImuScale) << judgement.finding->text;
}

// The rate is that of a recording. At one in a thousand, three and more alarms in 300 draws have a
// probability of 0.4 %.
TEST(JudgeImu, RaisesFalseAlarmsAtMostOnceInAThousandDraws) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> within(-1.0, 1.0);
  int alarms = 0;
  for (unsigned seed = 101; seed <= 400; ++seed) {
    Recording recording = Record(seed, std::exp2(-2.0 + 2.0 * within(rng)), 3.0 + within(rng));
    TurnMount(recording, 2.0 * kDegree * within(rng) * Eigen::Vector3d::UnitX());
    const double gyroscope = 1.0 + 0.02 * within(rng), depth = 1.0 + 0.02 * within(rng);
    const Stamp delay = FromSeconds(0.02 * within(rng));
    ForEachReading(recording, [&](ImuSample& s) {
      s.gyroscope *= gyroscope;
      s.stamp += delay;
    });
    for (StampedPose& p : recording.poses) p.pose = Pose(p.pose.q(), depth * p.pose.p());
    alarms += JudgementOf(recording).agreement >= ImuAgreement::kUnconfirmed ? 1 : 0;
  }
  EXPECT_LE(alarms, 2);
}

// As on a vehicle with an IMU in use, whose readings of twice the rate pull the poses along, so
// that neither the rate nor half of it explains how they turn.
TEST(JudgeImu, ContradictsAGyroscopeThatPullsThePosesOfACameraThatTurnsLittle) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Recording recording = Record(seed, 0.17, 4.5);
    ForEachReading(recording, [](ImuSample& s) { s.gyroscope *= 2.0; });
    Eigen::Quaterniond before = recording.poses.front().pose.q(), pulled = before;
    for (StampedPose& p : recording.poses) {
      pulled = pulled * so3::Exp(1.4 * so3::Log(before.conjugate() * p.pose.q()));
      before = p.pose.q();
      p.pose = Pose(pulled, p.pose.p());
    }
    EXPECT_EQ(JudgementOf(recording).agreement, ImuAgreement::kContradicted) << seed;
  }
}

// A fault and what is to be found.
struct Fault {
  const char* name;
  SensorFault fault;
  const char* text;  // a part of it
  std::function<void(Recording&)> apply;
};

std::vector<Fault> Faults() {
  const auto readings = [](const std::function<void(ImuSample&)>& change) {
    return [change](Recording& recording) { ForEachReading(recording, change); };
  };
  const auto mount = [](const std::function<Pose(const Pose&)>& change) {
    return [change](Recording& r) { r.calibration.T_BC = change(r.calibration.T_BC); };
  };
  return {
      {"inverted", SensorFault::kImuMount, "inverted",
       mount([](const Pose& T) { return T.Inverse(); })},
      {"turned", SensorFault::kImuMount, "rotation of T_BC is about", mount([](const Pose& T) {
         return Pose(T.q() * so3::Exp({0.0, 0.7, 0.0}), T.p());
       })},
      {"metres as millimetres", SensorFault::kImuLeverArm, "in mm",
       mount([](const Pose& T) { return Pose(T.q(), 1e3 * T.p()); })},
      {"far from the camera", SensorFault::kImuLeverArm, "instead of",
       mount([](const Pose& T) { return Pose(T.q(), Eigen::Vector3d(0.0, 2.0, 0.0)); })},
      {"y and z", SensorFault::kImuAxes, "x, z, y", readings([](ImuSample& s) {
         std::swap(s.gyroscope.y(), s.gyroscope.z());
         std::swap(s.accelerometer.y(), s.accelerometer.z());
       })},
      {"y and z of the gyroscope", SensorFault::kImuAxes, "gyroscope",
       readings([](ImuSample& s) { std::swap(s.gyroscope.y(), s.gyroscope.z()); })},
      {"x and y of the accelerometer", SensorFault::kImuAxes, "accelerometer",
       readings([](ImuSample& s) { std::swap(s.accelerometer.x(), s.accelerometer.y()); })},
      {"signs", SensorFault::kImuSign, "all readings", readings([](ImuSample& s) {
         s.gyroscope *= -1.0;
         s.accelerometer *= -1.0;
       })},
      {"sign of the gyroscope", SensorFault::kImuSign, "gyroscope",
       readings([](ImuSample& s) { s.gyroscope *= -1.0; })},
      {"sign of the accelerometer", SensorFault::kImuSign, "accelerometer",
       readings([](ImuSample& s) { s.accelerometer *= -1.0; })},
      {"degrees", SensorFault::kImuScale, "deg/s",
       readings([](ImuSample& s) { s.gyroscope /= kDegree; })},
      {"radians twice", SensorFault::kImuScale, "once too often",
       readings([](ImuSample& s) { s.gyroscope *= kDegree; })},
      {"55 ms ahead", SensorFault::kImuClock, "ahead",
       readings([](ImuSample& s) { s.stamp += 55'000'000; })},
      {"100 ms ahead", SensorFault::kImuClock, "ahead",
       readings([](ImuSample& s) { s.stamp += 100'000'000; })},
      {"200 ms behind", SensorFault::kImuClock, "behind",
       readings([](ImuSample& s) { s.stamp -= 200'000'000; })},
      {"clock twice as fast", SensorFault::kImuClock, "twice",
       [](Recording& r) { StretchStamps(r, 2.0); }},
      {"clock 4 % fast", SensorFault::kImuClock, "% faster",
       [](Recording& r) { StretchStamps(r, 1.04); }},
      {"clock 5 % slow", SensorFault::kImuClock, "% slower",
       [](Recording& r) { StretchStamps(r, 0.95); }},
  };
}

TEST(JudgeImu, NamesEachFault) {
  for (const Fault& fault : Faults()) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      Recording recording = Record(seed, 1.0, 8.0);
      fault.apply(recording);
      const ImuJudgement judgement = JudgementOf(recording);
      ASSERT_EQ(judgement.agreement, ImuAgreement::kContradicted) << fault.name << " " << seed;
      ASSERT_TRUE(judgement.finding);
      EXPECT_EQ(judgement.finding->fault, fault.fault)
          << fault.name << " " << seed << ": " << judgement.finding->text;
      EXPECT_NE(judgement.finding->text.find(fault.text), std::string::npos)
          << fault.name << ": " << judgement.finding->text;
    }
  }
}

// A vehicle turns by a fifth of what a hand does: the gyroscope's faults must be named all the
// same.
TEST(JudgeImu, NamesFaultsOfTheGyroscopeInLittleMotion) {
  for (const Fault& fault : Faults()) {
    const std::string name = fault.name;
    const bool turns = name == "y and z" || name == "y and z of the gyroscope" ||
                       name == "sign of the gyroscope" || name == "inverted";
    if (!turns) continue;
    for (unsigned seed = 1; seed <= 5; ++seed) {
      Recording recording = Record(seed, 0.2, 5.0);
      fault.apply(recording);
      const ImuJudgement judgement = JudgementOf(recording);
      EXPECT_EQ(judgement.agreement, ImuAgreement::kContradicted) << name << " " << seed;
      ASSERT_TRUE(judgement.finding) << name << " " << seed;
      EXPECT_NE(judgement.finding->fault, SensorFault::kImuInconsistent) << name << " " << seed;
    }
  }
}

// Too little for a contradiction of the gyroscope alone, whose free fit explains hardly more.
TEST(JudgeImu, NamesAMountThatIsOffByTwelveDegrees) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Recording recording = Record(seed, 0.3, 5.0);
    TurnMount(recording, 12.0 * kDegree * Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
    const ImuJudgement judgement = JudgementOf(recording);
    ASSERT_TRUE(judgement.finding) << seed;
    EXPECT_TRUE(judgement.is_named) << seed;
    EXPECT_EQ(judgement.finding->fault, SensorFault::kImuMount) << judgement.finding->text;
  }
}

TEST(JudgeImu, NamesAGyroscopeThatReadsTwiceOrHalfTheRate) {
  for (const double factor : {0.5, 2.0}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      Recording recording = Record(seed, 0.3, 5.0);
      ForEachReading(recording, [factor](ImuSample& s) { s.gyroscope *= factor; });
      const ImuJudgement judgement = JudgementOf(recording);
      ASSERT_TRUE(judgement.finding) << factor << " " << seed;
      EXPECT_EQ(judgement.finding->fault, SensorFault::kImuScale) << judgement.finding->text;
    }
  }
}

TEST(JudgeImu, NamesTheUnitOfALeverArmInCentimetres) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Recording recording = Record(seed, 1.0, 5.0);
    const Pose T_BC = recording.calibration.T_BC;
    recording.calibration.T_BC = Pose(T_BC.q(), 100.0 * T_BC.p());
    const ImuJudgement judgement = JudgementOf(recording);
    ASSERT_TRUE(judgement.finding) << seed;
    EXPECT_EQ(judgement.finding->fault, SensorFault::kImuLeverArm) << judgement.finding->text;
  }
}

// Also where the depth is five times too large or too small: that is no fault of the arm.
TEST(JudgeImu, BelievesALongLeverArmThatIsRight) {
  for (const double scale : {1.0, 5.0, 0.2}) {
    Recording recording = Record(1, 1.0, 8.0);
    const Eigen::Vector3d far(0.0, 2.0, 0.0);
    const Pose T_BC = recording.calibration.T_BC;
    for (StampedPose& p : recording.poses) {
      p.pose = p.pose * Pose(Eigen::Quaterniond::Identity(), T_BC.q().conjugate() * far);
    }
    for (StampedPose& p : recording.poses) p.pose = Pose(p.pose.q(), scale * p.pose.p());
    recording.calibration.T_BC = Pose(T_BC.q(), T_BC.p() + far);
    const ImuJudgement judgement = JudgementOf(recording);
    if (scale == 1.0) {
      EXPECT_EQ(judgement.agreement, ImuAgreement::kConsistent);
    } else {
      ASSERT_TRUE(judgement.finding) << scale;
      EXPECT_EQ(judgement.finding->fault, SensorFault::kDepthScale) << judgement.finding->text;
    }
  }
}

TEST(JudgeImu, NamesNoSingleCauseForTwoFaultsAtOnce) {
  Recording recording = Record(2, 1.0, 8.0);
  ForEachReading(recording, [](ImuSample& s) {
    std::swap(s.gyroscope.y(), s.gyroscope.z());
    s.accelerometer *= -1.0;
    std::swap(s.accelerometer.x(), s.accelerometer.y());
  });
  const ImuJudgement judgement = JudgementOf(recording);
  EXPECT_EQ(judgement.agreement, ImuAgreement::kContradicted);
  ASSERT_TRUE(judgement.finding);
  EXPECT_EQ(judgement.finding->fault, SensorFault::kImuInconsistent) << judgement.finding->text;
}

}  // namespace
}  // namespace highwall::imu_hypotheses_test
