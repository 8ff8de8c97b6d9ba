#include <highwall/frontend/input/imu_check.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

#include "support/test_paths.h"

namespace highwall::imu_check_test {
namespace {

using Kind = ImuFindingKind;

constexpr Stamp kSecond = 1'000'000'000;
constexpr VideoSpan kVideo{1 * kSecond, 9 * kSecond};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Returns the readings of a hand-held IMU at 200 Hz from 0.5 to 9.5 s that nods and sways by up to
// `rate` [rad/s].
std::vector<ImuSample> HandHeld(double rate = 1.0, unsigned seed = 1) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    return Eigen::Vector3d(sigma * normal(rng), sigma * normal(rng), sigma * normal(rng));
  };
  std::vector<ImuSample> samples;
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  for (int i = 0; i <= 1800; ++i) {
    const double t = 0.5 + i / 200.0;
    const Eigen::Vector3d w(rate * std::cos(1.3 * t), rate * std::sin(0.9 * t), 0.4 * rate);
    const Eigen::Vector3d a_W(0.8 * std::sin(2.0 * t), 0.5 * std::cos(3.0 * t), 0.3);
    samples.push_back({FromSeconds(t), w + noise(3e-3),
                       q_WB.conjugate() * (a_W + Eigen::Vector3d(0, 0, 9.81)) + noise(2e-2)});
    q_WB = q_WB * so3::Exp(w / 200.0);
  }
  return samples;
}

// Returns the only finding.
ImuFinding Only(const std::vector<ImuSample>& samples, const VideoSpan& video = kVideo) {
  const std::vector<ImuFinding> findings = CheckImu(samples, video);
  EXPECT_EQ(findings.size(), 1U);
  for (const ImuFinding& finding : findings) {
    EXPECT_EQ(finding.text.find('\n'), std::string::npos) << finding.text;
  }
  return findings.empty() ? ImuFinding{.text = "nothing found"} : findings.front();
}

void ExpectWarning(const ImuFinding& finding, Kind kind, const std::string& text) {
  EXPECT_EQ(finding.kind, kind) << finding.text;
  EXPECT_EQ(finding.severity, ImuSeverity::kWarning);
  EXPECT_EQ(finding.text, text);
}

void ExpectFatal(const ImuFinding& finding, Kind kind, const std::string& text) {
  EXPECT_EQ(finding.kind, kind) << finding.text;
  EXPECT_EQ(finding.severity, ImuSeverity::kFatal);
  EXPECT_EQ(finding.text, text);
}

TEST(CheckImu, FindsNothingInASoundRecording) {
  for (const double rate : {0.0, 0.1, 1.0, 4.0}) {
    const auto samples = HandHeld(rate);
    EXPECT_TRUE(CheckImu(samples, kVideo).empty()) << rate;
    EXPECT_EQ(RepairImu(samples, {}).size(), samples.size());
  }
}

// At a rate of one in a thousand, three and more alarms in 300 draws have a probability of 0.4 %.
TEST(CheckImu, RaisesFalseAlarmsAtMostOnceInAThousandDraws) {
  int alarms = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    alarms += CheckImu(HandHeld(0.02 * (seed % 150), seed), kVideo).empty() ? 0 : 1;
  }
  EXPECT_LE(alarms, 2);
}

TEST(CheckImu, SetsAFewNanReadingsAside) {
  auto samples = HandHeld();
  samples[100].gyroscope.y() = kNan;
  samples[200].accelerometer.x() = std::numeric_limits<double>::infinity();
  ExpectWarning(Only(samples), Kind::kNotFinite,
                "2 of 1801 readings are NaN or infinite; left out");
  EXPECT_EQ(RepairImu(samples, {}).size(), 1799U);
}

TEST(CheckImu, GivesUpOnManyNanReadings) {
  auto samples = HandHeld();
  for (std::size_t i = 0; i < samples.size(); i += 5) samples[i].gyroscope.x() = kNan;
  ExpectFatal(Only(samples), Kind::kNotFinite, "361 of 1801 readings are NaN or infinite");
  for (ImuSample& sample : samples) sample.gyroscope.x() = kNan;
  const auto findings = CheckImu(samples, kVideo);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].text, "1801 of 1801 readings are NaN or infinite");
  EXPECT_EQ(findings[1].kind, Kind::kEmpty);
  EXPECT_EQ(CheckImu({}, kVideo).at(0).text, "holds no reading that can be used");
}

TEST(CheckImu, SetsAFewImpossibleReadingsAside) {
  auto samples = HandHeld();
  samples[200].accelerometer.x() = 1e6;
  samples[100].gyroscope.y() = -71.0;
  const ImuFinding finding = Only(samples);
  ExpectWarning(finding, Kind::kImpossible,
                "2 of 1801 readings are beyond what any sensor measures (70 rad/s, 4000 m/s^2); "
                "left out");
  EXPECT_EQ(finding.reading, 100U);
  const auto repaired = RepairImu(samples, {});
  EXPECT_EQ(repaired.size(), 1799U);
  EXPECT_TRUE(std::all_of(repaired.begin(), repaired.end(), IsPossible));
}

TEST(CheckImu, JudgesImpossibleReadingsInTheirUnit) {
  // 500 g, and 5000 m/s^2, which is 510 g, are impossible; 300 g are possible.
  auto samples = HandHeld();
  for (ImuSample& sample : samples) sample.accelerometer /= 9.80665;
  samples[100].accelerometer.x() = 500.0;
  samples[300].accelerometer.x() = 300.0;
  const auto findings = CheckImu(samples, kVideo);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].kind, Kind::kAccelerometerInG);
  EXPECT_EQ(findings[1].kind, Kind::kImpossible);
  EXPECT_EQ(findings[1].reading, 100U);
  EXPECT_EQ(RepairImu(samples, findings).size(), 1800U);
}

TEST(CheckImu, GivesUpOnManyImpossibleReadings) {
  auto samples = HandHeld();
  for (std::size_t i = 0; i < samples.size(); i += 5) samples[i].accelerometer.x() = 1e9;
  EXPECT_EQ(Only(samples).kind, Kind::kImpossible);
  EXPECT_EQ(Only(samples).severity, ImuSeverity::kFatal);
}

TEST(CheckImu, AWrongUnitIsSaidOnceAndNotAsImpossibleReadings) {
  auto samples = HandHeld();
  for (ImuSample& sample : samples) sample.accelerometer *= 1000.0;  // mm/s^2
  EXPECT_EQ(Only(samples).kind, Kind::kAccelerometerImplausible);
  samples = HandHeld(4.0);
  for (ImuSample& sample : samples) sample.gyroscope *= 57.29578;
  EXPECT_EQ(Only(samples).kind, Kind::kGyroscopeInDegrees);
}

TEST(CheckImu, OneSpikeOfTheGyroscopeIsNoUnit) {
  auto samples = HandHeld();
  samples[100].gyroscope.y() = 1e6;
  EXPECT_EQ(Only(samples).kind, Kind::kImpossible);
}

TEST(CheckImu, SortsAndDropsDuplicates) {
  auto samples = HandHeld();
  std::swap(samples[50], samples[51]);
  ExpectWarning(Only(samples), Kind::kOutOfOrder,
                "1 stamps are smaller than the one before; sorted");
  const auto sorted = RepairImu(samples, {});
  EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end(),
                             [](auto& a, auto& b) { return a.stamp < b.stamp; }));
  samples = HandHeld();
  samples[70].stamp = samples[69].stamp;
  ExpectWarning(Only(samples), Kind::kDuplicates,
                "1 stamps are there twice; the first reading stays");
  EXPECT_EQ(RepairImu(samples, {}).size(), 1800U);
  EXPECT_EQ(RepairImu(samples, {})[69].gyroscope, samples[69].gyroscope);
}

TEST(CheckImu, FindsAnotherClock) {
  ExpectFatal(Only(HandHeld(), {1000 * kSecond, 1010 * kSecond}), Kind::kOtherClock,
              "readings from 0.500000 to 9.500000 s do not meet the video, 1000.000000 to "
              "1010.000000 s: another clock");
}

TEST(CheckImu, FindsStampsThatElapseAtAnotherRate) {
  ImuCheckOptions options{.rate = 200.0};
  EXPECT_TRUE(CheckImu(HandHeld(), kVideo, options).empty());
  auto samples = HandHeld();
  for (ImuSample& sample : samples) sample.stamp = kSecond / 2 + 2 * (sample.stamp - kSecond / 2);
  const std::vector<ImuFinding> findings = CheckImu(samples, kVideo, options);
  ASSERT_FALSE(findings.empty());
  ExpectFatal(findings.front(), Kind::kClockRate,
              "readings come at 100 Hz over 18 s, not at the stated 200 Hz over the 8 s of the "
              "video: divide the differences of their stamps by 2");
  samples = HandHeld();
  for (ImuSample& sample : samples) sample.stamp = 3 * kSecond + (sample.stamp - kSecond / 2) / 2;
  EXPECT_EQ(CheckImu(samples, kVideo, options).front().kind, Kind::kClockRate);
  // A video of the first half of a recording, or a rate that is stated wrongly, is no fault.
  EXPECT_TRUE(CheckImu(HandHeld(), {1 * kSecond, 5 * kSecond}, options).empty());
  options.rate = 400.0;
  EXPECT_TRUE(CheckImu(HandHeld(), kVideo, options).empty());
}

TEST(CheckImu, FindsAnImuThatIsShorterThanTheVideo) {
  ExpectWarning(Only(HandHeld(), {0, 9 * kSecond}), Kind::kStartsLate,
                "begins 0.5 s after the video; RGB-D alone until then");
  ExpectWarning(Only(HandHeld(), {1 * kSecond, 12 * kSecond}), Kind::kEndsEarly,
                "ends 2.5 s before the video; RGB-D alone from there");
  EXPECT_TRUE(CheckImu(HandHeld(), {kSecond / 2 - kSecond / 20, 9 * kSecond}).empty());
}

TEST(CheckImu, FindsGapsAboveATenthOfASecond) {
  auto samples = HandHeld();
  samples.erase(samples.begin() + 1000, samples.begin() + 1049);  // 0.25 s
  samples.erase(samples.begin() + 300, samples.begin() + 319);    // 0.1 s: not yet a gap
  ExpectWarning(Only(samples), Kind::kGaps,
                "1 gap above 0.1 s, the longest of 0.25 s at 5.495000; RGB-D alone across them");
  samples.erase(samples.begin() + 500, samples.begin() + 530);
  EXPECT_TRUE(Only(samples).text.starts_with("2 gaps above 0.1 s, the longest of 0.25 s"));
}

TEST(CheckImu, FindsAFrozenGyroscope) {
  auto samples = HandHeld();
  for (std::size_t i = 600; i < 660; ++i) samples[i].gyroscope = samples[600].gyroscope;
  ExpectFatal(Only(samples), Kind::kFrozenGyroscope,
              "gyroscope is frozen: it repeats one reading at 3.500000");
  for (ImuSample& sample : samples) sample.gyroscope.setZero();
  ExpectFatal(Only(samples), Kind::kFrozenGyroscope,
              "gyroscope is frozen: it repeats one reading from beginning to end");
}

TEST(CheckImu, FindsAFrozenAccelerometer) {
  auto samples = HandHeld();
  for (std::size_t i = 600; i < 660; ++i) samples[i].accelerometer = samples[600].accelerometer;
  ExpectFatal(Only(samples), Kind::kFrozenAccelerometer,
              "accelerometer is frozen: it repeats one reading at 3.500000");
}

TEST(CheckImu, InterpolatesReadingsThatAreHeldForThreeStamps) {
  auto samples = HandHeld();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].accelerometer = samples[i - i % 3].accelerometer;
  }
  const ImuFinding finding = Only(samples);
  EXPECT_EQ(finding.kind, Kind::kRepeatedReadings);
  EXPECT_EQ(finding.severity, ImuSeverity::kWarning);
  EXPECT_TRUE(finding.text.starts_with("accelerometer repeats each reading 3 times"))
      << finding.text;
  const auto repaired = RepairImu(samples, std::vector{finding});
  ASSERT_EQ(repaired.size(), samples.size());
  for (std::size_t i = 0; i + 3 < samples.size(); i += 3) {
    EXPECT_EQ(repaired[i].accelerometer, samples[i].accelerometer);
    const Eigen::Vector3d third =
        (2.0 * samples[i].accelerometer + samples[i + 3].accelerometer) / 3.0;
    // The stamps are whole nanoseconds.
    EXPECT_TRUE(repaired[i + 1].accelerometer.isApprox(third, 1e-6)) << i;
    EXPECT_EQ(repaired[i + 1].gyroscope, samples[i + 1].gyroscope);
  }
}

TEST(CheckImu, TakesAnImuWithoutNoiseAtRestForSound) {
  auto samples = HandHeld();
  for (std::size_t i = 0; i < 400; ++i) {
    samples[i].gyroscope.setZero();
    samples[i].accelerometer = {0, 0, 9.81};
  }
  EXPECT_TRUE(CheckImu(samples, kVideo).empty());
}

TEST(CheckImu, ConvertsAnAccelerometerThatIsCertainlyInG) {
  auto samples = HandHeld();
  for (ImuSample& sample : samples) sample.accelerometer /= 9.80665;
  const ImuFinding finding = Only(samples);
  EXPECT_EQ(finding.kind, Kind::kAccelerometerInG);
  EXPECT_EQ(finding.severity, ImuSeverity::kWarning) << finding.text;
  EXPECT_TRUE(finding.text.ends_with(": it is in g, not in m/s^2; converted")) << finding.text;
  const auto repaired = RepairImu(samples, std::vector{finding}), expected = HandHeld();
  ASSERT_EQ(repaired.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_TRUE(repaired[i].accelerometer.isApprox(expected[i].accelerometer, 1e-14));  // rounding
  }
}

TEST(CheckImu, NamesTheLikelyUnitOfAnAccelerometerThatIsNot) {
  auto samples = HandHeld();
  for (ImuSample& sample : samples) sample.accelerometer *= 1.2 / 9.9;
  ImuFinding finding = Only(samples);
  EXPECT_EQ(finding.kind, Kind::kAccelerometerInG);
  EXPECT_EQ(finding.severity, ImuSeverity::kFatal);
  EXPECT_TRUE(finding.text.ends_with(": it is likely in g, not in m/s^2; multiply by 9.80665"))
      << finding.text;
  for (ImuSample& sample : samples) sample.accelerometer *= 1000.0;
  finding = Only(samples);
  EXPECT_EQ(finding.kind, Kind::kAccelerometerImplausible);
  EXPECT_EQ(finding.severity, ImuSeverity::kFatal);
  EXPECT_NE(finding.text.find("the unit is unknown"), std::string::npos) << finding.text;
}

TEST(CheckImu, NamesColumnsOfTheAccelerometerThatComeFirst) {
  for (const double rate : {0.0, 0.1, 1.0, 4.0}) {
    for (const double gyroscope_unit : {1.0, 57.29578}) {
      for (const double unit : {1.0, 1.0 / 9.80665}) {
        SCOPED_TRACE(std::to_string(rate) + " " + std::to_string(unit));
        auto samples = HandHeld(rate);
        for (ImuSample& sample : samples) {
          const Eigen::Vector3d rates = gyroscope_unit * sample.gyroscope;
          sample.gyroscope = unit * sample.accelerometer;
          sample.accelerometer = rates;
        }
        const ImuFinding finding = Only(samples);
        EXPECT_EQ(finding.kind, Kind::kColumnsExchanged) << finding.text;
        EXPECT_EQ(finding.severity, ImuSeverity::kFatal);
        EXPECT_TRUE(finding.text.starts_with("the columns of the accelerometer come first"));
      }
    }
  }
}

TEST(CheckImu, NamesGravityThatWasTakenOff) {
  for (const double rate : {0.1, 1.0, 4.0}) {
    for (const double strength : {0.05, 1.0, 1.35, 3.0}) {  // times a median of 0.7 m/s^2
      SCOPED_TRACE(std::to_string(rate) + " " + std::to_string(strength));
      auto samples = HandHeld(rate);
      Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
      for (ImuSample& sample : samples) {  // rotates as HandHeld() does
        sample.accelerometer -= q_WB.conjugate() * Eigen::Vector3d(0, 0, 9.81);
        sample.accelerometer *= strength;
        const double t = ToSeconds(sample.stamp);
        const Eigen::Vector3d w(rate * std::cos(1.3 * t), rate * std::sin(0.9 * t), 0.4 * rate);
        q_WB = q_WB * so3::Exp(w / 200.0);
      }
      const ImuFinding finding = Only(samples);
      EXPECT_EQ(finding.kind, Kind::kGravityRemoved) << finding.text;
      EXPECT_EQ(finding.severity, ImuSeverity::kFatal);
      EXPECT_TRUE(finding.text.ends_with(
          ": gravity was likely taken off already; record the accelerometer as it reads, with "
          "gravity"))
          << finding.text;
    }
  }
}

TEST(CheckImu, FindsAGyroscopeInDegreesByItsRate) {
  auto samples = HandHeld();
  for (ImuSample& sample : samples) sample.gyroscope *= 57.29578;
  const ImuFinding finding = Only(samples);
  EXPECT_EQ(finding.kind, Kind::kGyroscopeInDegrees);
  EXPECT_EQ(finding.severity, ImuSeverity::kFatal);
  EXPECT_TRUE(
      finding.text.ends_with(": it is likely in deg/s, not in rad/s; multiply by 0.0174533"))
      << finding.text;
}

TEST(CheckImu, FindsAGyroscopeInDegreesOfASlowMotionByTheTurningOfGravity) {
  auto samples = HandHeld(0.06);  // 3 deg/s
  for (ImuSample& sample : samples) sample.gyroscope *= 57.29578;
  ExpectFatal(Only(samples), Kind::kGyroscopeInDegrees,
              "gyroscope: taken for deg/s it explains how gravity turns, taken for rad/s it does "
              "not: it is likely in deg/s; multiply by 0.0174533");
}

TEST(CheckImu, PutsTheWorstFirst) {
  auto samples = HandHeld();
  samples[70].stamp = samples[69].stamp;
  for (ImuSample& sample : samples) sample.gyroscope *= 57.29578;
  const auto findings = CheckImu(samples, kVideo);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].kind, Kind::kGyroscopeInDegrees);
  EXPECT_TRUE(HasFatal(findings));
  EXPECT_FALSE(HasFatal(std::span(findings).subspan(1)));
}

TEST(CheckImu, LeavesTheSignOfGravityToTheEstimator) {
  auto samples = HandHeld();
  for (ImuSample& sample : samples) sample.accelerometer *= -1.0;
  EXPECT_TRUE(CheckImu(samples, kVideo).empty());
  ExpectFatal(AccelerometerReversed(), Kind::kAccelerometerReversed,
              "accelerometer: its sign is reversed, it reads gravity instead of the specific force "
              "(at rest it must point up); multiply by -1");
}

TEST(CheckImu, FindsNothingInARealRecording) {
  const std::filesystem::path file =
      std::filesystem::path(testing::kSharedData) / "euroc_v101" / "imu.csv";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "shared/data has no euroc_v101";
  constexpr VideoSpan kV101{1403715273262142976, 1403715300000000000};
  const ImuRecording imu = ReadImu(file, kV101);
  EXPECT_EQ(imu.warning, "");
  for (const ImuFinding& finding : CheckImu(imu.samples, kV101)) ADD_FAILURE() << finding.text;
  std::vector<ImuSample> in_degrees = imu.samples;
  for (ImuSample& sample : in_degrees) sample.gyroscope *= 57.29578;
  EXPECT_EQ(CheckImu(in_degrees, kV101).at(0).kind, Kind::kGyroscopeInDegrees);
}

TEST(DropExceededRanges, ARangeThatReadingsLeaveIsDroppedAndSaid) {
  const std::vector<ImuSample> samples = HandHeld(4.0);
  ImuCalibration calibration;
  calibration.accelerometer_range = 4.0;  // is 4 g
  calibration.gyroscope_range = 2.0;      // is 2 rad/s
  const auto findings = DropExceededRanges(samples, &calibration);
  ASSERT_EQ(findings.size(), 2U);
  for (const ImuFinding& finding : findings) {
    EXPECT_EQ(finding.kind, Kind::kRangeExceeded);
    EXPECT_EQ(finding.severity, ImuSeverity::kWarning);
    EXPECT_NE(finding.text.find(" of 1801 readings of the "), std::string::npos) << finding.text;
  }
  EXPECT_NE(findings[0].text.find("gyroscope are beyond its range of 2 rad/s, the first at "),
            std::string::npos)
      << findings[0].text;
  EXPECT_NE(findings[1].text.find("imu: accelerometer_range of the calibration is ignored; is it "
                                  "in m/s^2?"),
            std::string::npos)
      << findings[1].text;
  EXPECT_TRUE(std::isinf(calibration.accelerometer_range));
  EXPECT_TRUE(std::isinf(calibration.gyroscope_range));
}

TEST(DropExceededRanges, AReadingJustBeyondTheRangeIsOneAtItsEnd) {
  std::vector<ImuSample> samples = HandHeld();
  ImuCalibration calibration;
  calibration.accelerometer_range = 39.2;
  calibration.gyroscope_range = 17.4;
  samples[100].accelerometer.z() = -40.5;  // a scale error of 3 %
  samples[200].gyroscope.y() = 17.9;
  for (const std::size_t i : {300U, 500U, 700U}) samples[i].gyroscope.x() = -30.0;  // isolated
  EXPECT_TRUE(DropExceededRanges(samples, &calibration).empty());
  EXPECT_EQ(calibration.accelerometer_range, 39.2);
  EXPECT_EQ(calibration.gyroscope_range, 17.4);
}

TEST(CheckImu, RefusesBadOptions) {
  const auto samples = HandHeld();
  EXPECT_THROW(CheckImu(samples, kVideo, {.max_step = 0.0}), InvalidArgument);
  EXPECT_THROW(CheckImu(samples, kVideo, {.frozen_readings = 1}), InvalidArgument);
  EXPECT_THROW(CheckImu(samples, kVideo, {.max_bad_share = 2.0}), InvalidArgument);
  EXPECT_THROW(CheckImu(samples, kVideo, {.max_angular_rate = kNan}), InvalidArgument);
}

}  // namespace
}  // namespace highwall::imu_check_test
