// Runs `highwall slam` on a dataset with an IMU: its weights, and its response to bad readings.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::slam_imu_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::CountLines;
using testing::Outcome;
using testing::ReadText;
using testing::TemporaryDirectory;
using testing::WriteText;

// A walk with an IMU whose readings are valid until the test corrupts them.
class SlamWithImu : public ::testing::Test {
 protected:
  static constexpr int kFrames = 12;  // at 6 Hz: two seconds

  void SetUp() override {
    simulate::SimulationOptions options;
    options.camera = {
        .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
    options.fps = 6.0;
    options.duration = kFrames / options.fps;
    simulate::WriteTum(simulate::SimulateRoom(options), dataset());
  }

  fs::path dataset() const { return folder_.path() / "dataset"; }
  fs::path run() const { return folder_.path() / "run"; }
  Outcome SlamOnDataset(const std::string& options) const {
    return testing::RunProgram(
        testing::kHighwallProgram,
        "slam --dataset " + dataset().string() + " --out " + run().string() + " " + options);
  }

  fs::path imu_file() const { return dataset() / "imu.csv"; }

  // Rewrites every reading, given as the numbers of its line; false drops the reading.
  void Spoil(const std::function<bool(std::vector<double>& reading)>& change) const {
    std::istringstream in(ReadText(imu_file()));
    std::ostringstream out;
    out.precision(17);
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with('#')) continue;
      std::istringstream columns(line);
      std::vector<double> reading;
      for (std::string column; std::getline(columns, column, ',');) {
        reading.push_back(std::stod(column));
      }
      ASSERT_EQ(reading.size(), 7u) << line;
      if (!change(reading)) continue;
      out << static_cast<std::int64_t>(reading[0]);
      for (std::size_t i = 1; i < reading.size(); ++i) out << ',' << reading[i];
      out << '\n';
    }
    WriteText(imu_file(), out.str());
  }

  // Expects an RGB-D run: exit code 0, a warning with every part, and every frame tracked.
  void ExpectFallback(const std::vector<std::string>& parts) const {
    const Outcome outcome = SlamOnDataset("--no-map --json");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("highwall slam: warning: ")) << outcome.err;
    for (const std::string& part : parts) EXPECT_TRUE(Contains(outcome.err, part)) << outcome.err;
    const json report = json::parse(outcome.out);
    EXPECT_EQ(report["lost_frames"], 0);
    EXPECT_EQ(report["frames"], kFrames);
    EXPECT_FALSE(report.contains("imu") && report["imu"].contains("initialized")) << report;
    const Trajectory truth = ReadTumTrajectory(dataset() / "groundtruth.txt");
    EXPECT_LT(AbsolutePoseError(truth, ReadTumTrajectory(run() / "trajectory.txt")).statistics.rmse,
              0.02);
  }

  // Expects one line that contains every part, exit code 2, and no output files.
  void ExpectRefused(const std::vector<std::string>& parts, const std::string& options = "") const {
    testing::ExpectRefused(SlamOnDataset(options), 2, parts);
    EXPECT_FALSE(fs::exists(run()));
  }

 private:
  TemporaryDirectory folder_;
};

TEST_F(SlamWithImu, TakesTheImuByDefaultAndEachOfItsWeights) {
  for (const char* choice : {"", "--imu paper", "--imu fixed:2"}) {
    const Outcome outcome = SlamOnDataset("--no-map --json " + std::string(choice));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const json report = json::parse(outcome.out);
    EXPECT_TRUE(report["imu"].contains("initialized")) << choice << outcome.err;
    const std::string policy = *choice == '\0' ? "consistent" : std::string(choice).substr(6);
    EXPECT_EQ(report["options"]["imu"], policy.substr(0, policy.find(':'))) << choice;
    EXPECT_EQ(report["lost_frames"], 0) << choice;
    EXPECT_EQ(report["options"]["inertial"], "tight") << choice;
    EXPECT_GT(report["imu"]["tight_updates"]["count"], 0) << choice;
    EXPECT_EQ(report["imu"]["refused_tight_updates"], 0) << choice;
    if (policy == "fixed:2") {
      EXPECT_EQ(report["imu"]["mean_weight"], 2.0);
    }
    const json& intervals = report["imu"]["intervals"];
    ASSERT_FALSE(intervals["weight"].empty()) << choice;
    EXPECT_EQ(intervals["stamp"].size(), intervals["weight"].size());
    EXPECT_EQ(intervals["innovation_per_dof"].size(), intervals["weight"].size());
    const double sum = std::accumulate(intervals["weight"].begin(), intervals["weight"].end(), 0.0,
                                       [](double s, const json& w) { return s + w.get<double>(); });
    EXPECT_NEAR(sum / static_cast<double>(intervals["weight"].size()),
                report["imu"]["mean_weight"].get<double>(), 1e-12);
    EXPECT_TRUE(Contains(ReadText(run() / "imu.svg"), "weight of its residuals")) << choice;
  }
  const Outcome outcome = SlamOnDataset("--no-map --json --imu off");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  const json report = json::parse(outcome.out);
  EXPECT_FALSE(report.contains("imu"));
  EXPECT_FALSE(fs::exists(run() / "imu.svg")) << "of the run before";
  EXPECT_EQ(report["options"]["imu"], "off");
}

TEST_F(SlamWithImu, ReportsTheSmootherThatRan) {
  const Outcome outcome = SlamOnDataset("--no-map --json --set inertial.coupling=loose");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["options"]["inertial"], "loose");
  EXPECT_EQ(report["imu"]["tight_updates"]["count"], 0);
}

TEST_F(SlamWithImu, TheWindowOfLandmarksHasTheExtrinsicsAsUnknownsWhereAsked) {
  const Outcome outcome = SlamOnDataset("--no-map --json --set inertial.estimate_extrinsics=true");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["options"]["inertial"], "tight");
  EXPECT_GT(report["imu"]["tight_updates"]["count"], 0);
  EXPECT_EQ(report["imu"]["refused_tight_updates"], 0);
  EXPECT_TRUE(report["imu"].contains("extrinsics"));
}

TEST_F(SlamWithImu, RefusesOtherWeightsInOneLine) {
  for (const char* choice : {"on", "fixed", "fixed:", "fixed:0", "fixed:-1", "fixed:nan",
                             "fixed:1e9", "fixed:2x", "Paper", "consistent", "''"}) {
    SCOPED_TRACE(choice);
    testing::ExpectRefused(SlamOnDataset("--imu " + std::string(choice)), 1, {"--imu"});
  }
}

TEST_F(SlamWithImu, AnImuThatIsAskedForMustBeThere) {
  fs::remove(imu_file());
  ExpectRefused({dataset().string(), "has no IMU"}, "--imu paper");
  EXPECT_EQ(SlamOnDataset("--no-map").exit_code, 0);
}

TEST_F(SlamWithImu, ContinuesWithoutAnImuWhoseReadingsAreNotNumbers) {
  Spoil([](std::vector<double>& reading) {
    reading[4] = std::numeric_limits<double>::quiet_NaN();
    return true;
  });
  ExpectFallback({"imu.csv", "the IMU is not used"});
}

TEST_F(SlamWithImu, ContinuesWithoutAFrozenImu) {
  std::vector<double> first;
  Spoil([&](std::vector<double>& reading) {
    if (first.empty()) first = reading;
    std::copy(first.begin() + 1, first.end(), reading.begin() + 1);
    return true;
  });
  ExpectFallback({"imu.csv", "the IMU is not used"});
}

TEST_F(SlamWithImu, LeavesAnImpossibleReadingOutAndNamesItsLine) {
  for (const double value : {1e6, 3e7, 1e9}) {
    SCOPED_TRACE(value);
    int line = 0;
    Spoil([&](std::vector<double>& reading) {
      // These lie in the last third, after the initialization.
      if (++line == 440) reading[4] = value;
      return true;
    });
    const Outcome outcome = SlamOnDataset("--no-map --json");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(CountLines(outcome.err), 1U) << outcome.err;
    EXPECT_TRUE(Contains(outcome.err, "imu.csv:440: 1 of ")) << outcome.err;
    EXPECT_TRUE(Contains(outcome.err, "left out")) << outcome.err;
    const json report = json::parse(outcome.out);
    EXPECT_EQ(report["lost_frames"], 0);
    EXPECT_EQ(report["imu"]["status"], "running");
    EXPECT_EQ(report["imu"]["restarts"], 0);
    const Trajectory truth = ReadTumTrajectory(dataset() / "groundtruth.txt");
    EXPECT_LT(AbsolutePoseError(truth, ReadTumTrajectory(run() / "trajectory.txt")).statistics.rmse,
              0.02);
  }
}

TEST_F(SlamWithImu, ConvertsReadingsInGWithAWarning) {
  Spoil([](std::vector<double>& reading) {
    for (int i = 4; i < 7; ++i) reading[static_cast<std::size_t>(i)] /= 9.80665;
    return true;
  });
  const Outcome outcome = SlamOnDataset("--no-map --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, " g")) << outcome.err;
  EXPECT_TRUE(json::parse(outcome.out)["imu"].contains("initialized")) << outcome.err;
}

TEST_F(SlamWithImu, IgnoresARangeThatTheReadingsLeaveAndSaysSo) {
  const fs::path calibration = dataset() / "calibration.yaml";
  WriteText(calibration, ReadText(calibration) + "  accelerometer_range: 9.9\n");
  int line = 0;
  Spoil([&](std::vector<double>& reading) {
    if (++line <= 4) reading[6] = 12.0;
    return true;
  });
  const Outcome outcome = SlamOnDataset("--no-map --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "accelerometer are beyond its range of 9.9 m/s^2"))
      << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_TRUE(report["imu"].contains("initialized")) << outcome.err;
  EXPECT_EQ(report["imu"]["saturated_intervals"], 0);
}

TEST_F(SlamWithImu, SaysNothingOfARangeWhereTheReadingsAreInAnotherUnit) {
  const fs::path calibration = dataset() / "calibration.yaml";
  WriteText(calibration, ReadText(calibration) + "  gyroscope_range: 8.7\n");
  Spoil([](std::vector<double>& reading) {
    for (std::size_t i = 1; i < 4; ++i) reading[i] *= 180.0 / M_PI;
    return true;
  });
  const Outcome outcome = SlamOnDataset("--no-map --json");
  EXPECT_TRUE(Contains(outcome.err, "deg/s")) << outcome.err;
  EXPECT_FALSE(Contains(outcome.err, "range")) << outcome.err;
}

TEST_F(SlamWithImu, CountsIntervalsAtTheEndOfTheRange) {
  const fs::path calibration = dataset() / "calibration.yaml";
  WriteText(calibration, ReadText(calibration) + "  gyroscope_range: 20\n");
  int line = 0;
  Spoil([&](std::vector<double>& reading) {
    // Once in the last third, after the initialization.
    if (++line == 440) reading[1] = 20.0;
    return true;
  });
  const Outcome outcome = SlamOnDataset("--no-map --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["imu"]["saturated_intervals"], 1) << outcome.out;
  fs::remove_all(run());
  const Outcome text = SlamOnDataset("--no-map");
  EXPECT_TRUE(Contains(text.out, "images contradict 0 intervals, 1 intervals saturate the sensor"))
      << text.out;
}

TEST_F(SlamWithImu, ContinuesWithoutAGyroscopeInDegrees) {
  Spoil([](std::vector<double>& reading) {
    for (int i = 1; i < 4; ++i) reading[static_cast<std::size_t>(i)] *= 180.0 / M_PI;
    return true;
  });
  ExpectFallback({"imu.csv", "deg/s"});
}

TEST_F(SlamWithImu, ContinuesWithoutAnAccelerometerOfTheWrongSign) {
  Spoil([](std::vector<double>& reading) {
    for (int i = 4; i < 7; ++i) reading[static_cast<std::size_t>(i)] *= -1.0;
    return true;
  });
  ExpectFallback({"the IMU was not used"});
}

TEST_F(SlamWithImu, ContinuesWhereTheReadingsHaveGaps) {
  int line = 0;
  Spoil([&](std::vector<double>&) { return ++line % 120 < 70; });
  const Outcome outcome = SlamOnDataset("--no-map --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "gap")) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["lost_frames"], 0);
}

TEST_F(SlamWithImu, ContinuesWhereTheImuIsShorterThanTheVideo) {
  int line = 0;
  Spoil([&](std::vector<double>&) { return ++line < 350; });
  const Outcome outcome = SlamOnDataset("--no-map --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "imu.csv")) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["lost_frames"], 0);
  EXPECT_EQ(report["frames"], kFrames);
}

TEST_F(SlamWithImu, ContinuesWithoutAnImuOfAnotherClockUnlessTheImuIsRequired) {
  Spoil([](std::vector<double>& reading) {
    reading[0] += 1e15;
    return true;
  });
  ExpectRefused({"imu.csv", "another clock"}, "--imu paper");
  ExpectFallback({"imu.csv", "another clock", "the IMU is not used"});
}

TEST_F(SlamWithImu, ContinuesWithoutAMalformedImuUnlessTheImuIsRequired) {
  WriteText(imu_file(), "1000000000,0,0,0,0,0\n");
  ExpectRefused({"imu.csv:1: has 6 fields"}, "--imu paper");
  ExpectFallback({"imu.csv:1: has 6 fields", "the IMU is not used"});
}

TEST_F(SlamWithImu, UsesAnImuWithColumnsThatItsHeadingNames) {
  std::string text = "t;ax;ay;az;gx;gy;gz;mx;my;mz\n";
  std::istringstream lines(ReadText(imu_file()));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::ranges::replace(line, ',', ' ');
    std::istringstream fields(line);
    std::string t, wx, wy, wz, ax, ay, az;
    fields >> t >> wx >> wy >> wz >> ax >> ay >> az;
    for (const std::string& field : {t, ax, ay, az, wx, wy, wz}) text += field + ";";
    text += "0.2;0.1;\n";  // the last is empty
  }
  const Outcome usual = SlamOnDataset("--no-map --deterministic --json");
  const std::string poses = ReadText(run() / "trajectory.txt");
  WriteText(imu_file(), text);
  const Outcome outcome = SlamOnDataset("--no-map --deterministic --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, usual.err);
  EXPECT_EQ(ReadText(run() / "trajectory.txt"), poses);
}

}  // namespace
}  // namespace highwall::slam_imu_test
