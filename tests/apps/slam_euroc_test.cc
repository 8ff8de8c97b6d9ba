// Runs `highwall slam` on stereo images of EuRoC.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

#include "support/run_program.h"
#include "support/temporary_directory.h"
#include "support/test_paths.h"

namespace highwall::slam_euroc_test {
namespace {

namespace fs = std::filesystem;
using testing::Outcome;

const fs::path kShared = testing::kSharedData;

Outcome Slam(const fs::path& dataset, const fs::path& out, const std::string& options) {
  return testing::RunProgram(testing::kHighwallProgram, "slam --no-map --deterministic --dataset " +
                                                            dataset.string() + " --out " +
                                                            out.string() + " " + options);
}

// Poses of the IMU; during the clip the camera, 7 cm away, rotates by some degrees only.
Trajectory ReadTruth(const fs::path& csv) {
  Trajectory truth;
  std::ifstream stream(csv);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream numbers(line);
    Stamp stamp = 0;
    char comma = 0;
    double v[7];
    numbers >> stamp;
    for (double& x : v) numbers >> comma >> x;
    truth.push_back(
        {stamp, Pose(Eigen::Quaterniond(v[3], v[4], v[5], v[6]).normalized(), {v[0], v[1], v[2]})});
  }
  return truth;
}

TEST(SlamOfEuroc, TracksTheClipWithAndWithoutItsImu) {
  const fs::path clip = kShared / "euroc_v101_clip", csv = kShared / "euroc_v101/groundtruth.csv";
  if (!fs::exists(clip)) GTEST_SKIP() << "needs shared/data/euroc_v101_clip";
  const testing::TemporaryDirectory folder;
  const Trajectory truth = ReadTruth(csv);
  for (const std::string options : {"--imu off", ""}) {
    SCOPED_TRACE(options);
    const fs::path run = folder / (options.empty() ? "with" : "without");
    const Outcome outcome = Slam(clip, run, options);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Trajectory estimate = ReadTumTrajectory(run / "trajectory.txt");
    EXPECT_EQ(estimate.size(), 47U);
    EXPECT_LT(AbsolutePoseError(truth, estimate).statistics.rmse, 0.002);
  }
}

TEST(SlamOfEuroc, TakesNoOtherCalibration) {
  const fs::path clip = kShared / "euroc_v101_clip";
  if (!fs::exists(clip)) GTEST_SKIP() << "needs shared/data/euroc_v101_clip";
  const testing::TemporaryDirectory folder;
  testing::ExpectRefused(Slam(clip, folder / "run", "--config tum1"), 2,
                         {clip.string(), "leave --config out"});
  testing::ExpectRefused(testing::RunProgram(testing::kHighwallProgram, "info " + clip.string()), 2,
                         {clip.string(), "EuRoC"});
}

}  // namespace
}  // namespace highwall::slam_euroc_test
