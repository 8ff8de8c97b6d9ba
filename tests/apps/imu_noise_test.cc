// Runs `highwall imu-noise` on readings at rest, and on invalid input.
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/noise_at_rest.h"
#include "support/run_program.h"
#include "support/temporary_directory.h"
#include "support/test_paths.h"

namespace highwall::imu_noise_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::Outcome;

const ImuNoise kNoise{
    .gyroscope = 1.7e-4, .accelerometer = 2e-3, .gyroscope_walk = 2e-5, .accelerometer_walk = 3e-4};

class ImuNoiseCommand : public ::testing::Test {
 protected:
  fs::path file() const { return folder_ / "imu.csv"; }
  // Writes `duration` [s] of readings at rest, shaken from `moves` [s] on.
  void WriteReadings(double duration, double moves) const {
    std::ofstream stream(file());
    stream.precision(12);
    for (const ImuSample& sample : ImuAtRest(11, duration, 100.0, kNoise)) {
      const double t = ToSeconds(sample.stamp);
      const double shaken = t < moves ? 0.0 : 0.5 * std::sin(20.0 * t);
      stream << sample.stamp;
      for (const double w : sample.gyroscope) stream << ',' << w + shaken;
      for (const double a : sample.accelerometer) stream << ',' << a + shaken;
      stream << '\n';
    }
  }
  Outcome Run(const std::string& options) const {
    return testing::RunProgram(testing::kHighwallProgram, "imu-noise " + options);
  }

  const testing::TemporaryDirectory folder_;
};

TEST_F(ImuNoiseCommand, FindsTheDensitiesOfTheStretchAtRest) {
  WriteReadings(620.0, 600.0);
  for (const fs::path& input : {file(), file().parent_path()}) {
    const Outcome outcome = Run(input.string() + " --json");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const json report = json::parse(outcome.out);
    ASSERT_EQ(report["rest_s"].size(), 1U);
    EXPECT_NEAR(report["rest_s"][0][1].get<double>(), 600.0, 0.6) << "windows of half a second";
    const auto expect_held = [&](const char* sensor, const char* part, double truth) {
      const json& density = report[sensor][part];
      EXPECT_LE(density["low"], truth) << sensor << part;
      EXPECT_GE(density["high"], truth) << sensor << part;
    };
    expect_held("gyroscope", "white", kNoise.gyroscope);
    expect_held("gyroscope", "walk", kNoise.gyroscope_walk);
    expect_held("accelerometer", "white", kNoise.accelerometer);
    expect_held("accelerometer", "walk", kNoise.accelerometer_walk);
  }
}

TEST_F(ImuNoiseCommand, PrintsLinesForACalibrationAndNamesMissingOnes) {
  WriteReadings(12.0, 1e9);
  const Outcome outcome = Run(file().string() + " --plot " + (folder_ / "noise.svg").string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "\n  {gyroscope_noise: 0.0001")) << outcome.out;
  EXPECT_TRUE(Contains(outcome.out, ", accelerometer_noise: 0.00")) << outcome.out;
  EXPECT_TRUE(Contains(outcome.out, "not observed: gyroscope_walk, accelerometer_walk: "));
  const std::string plot = testing::ReadText(folder_ / "noise.svg");
  EXPECT_TRUE(Contains(plot, "</svg>"));
  EXPECT_TRUE(Contains(plot, "accelerometer"));
}

TEST_F(ImuNoiseCommand, TakesTheGivenStretchWithoutLookingForRest) {
  WriteReadings(20.0, 10.0);
  const Outcome outcome = Run(file().string() + " --from 12 --to 15 --assume-rest --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["readings"], 300);
}

TEST_F(ImuNoiseCommand, RefusesReadingsInMotionMissingOnesAndWrongUsage) {
  WriteReadings(20.0, 0.0);
  testing::ExpectRefused(Run(file().string()), 2, {file().string(), "never at rest"});
  testing::ExpectRefused(Run(file().string() + " --from 30"), 2, {file().string(), "--from"});
  EXPECT_EQ(Run(file().string() + " --from 5 --to 2").exit_code, 1);
  EXPECT_EQ(Run(file().string() + " --to nan").exit_code, 1);
  testing::ExpectRefused(Run(file().string() + " --assume-rest --from 1 --to 1.3"), 2,
                         {file().string(), "too few readings"});
  testing::ExpectRefused(Run((folder_ / "none.csv").string()), 2, {"none.csv", "is missing"});
  fs::create_directory(folder_ / "empty");
  testing::ExpectRefused(Run((folder_ / "empty").string()), 2, {"empty", "holds no imu.csv"});
  testing::ExpectRefused(Run(file().string() + " --plot noise.png"), 1, {".svg"});
}

}  // namespace
}  // namespace highwall::imu_noise_test
