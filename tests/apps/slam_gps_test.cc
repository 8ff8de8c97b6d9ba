// Runs `highwall simulate --gps`, and `highwall slam` on its output.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/pose.h>
#include <highwall/frontend/input/gps.h>

#include "run/gps_input.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/drive.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::slam_gps_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::Outcome;
using testing::ReadText;
using testing::WriteText;

class SlamWithGps : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<testing::TemporaryDirectory>("gps");
    simulate::SimulationOptions options = simulate::FieldTestOptions();
    options.duration = 8.0;  // 13 m
    options.fps = 10.0;
    options.camera = simulate::Scaled(options.camera, 0.3);
    options.exposure.mode = simulate::ExposureMode::kIdeal;
    simulate::WriteTum(simulate::SimulateDrive(options), dataset(), {},
                       {.gps = simulate::GpsOptions{.rate = 4.0, .sigma = 0.05}});
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static fs::path dataset() { return folder_->path() / "dataset"; }
  static fs::path run(const std::string& name) { return folder_->path() / name; }
  static Outcome Slam(const std::string& name, const std::string& options) {
    return testing::RunProgram(testing::kHighwallProgram,
                               "slam --dataset " + dataset().string() + " --out " +
                                   run(name).string() + " --no-map --deterministic " + options);
  }

  static std::unique_ptr<testing::TemporaryDirectory> folder_;
};

std::unique_ptr<testing::TemporaryDirectory> SlamWithGps::folder_;

TEST_F(SlamWithGps, TheFixesAreUsedAndTheirFrameIsFound) {
  for (const std::string imu : {"--imu off", ""}) {
    const Outcome outcome = Slam("on", imu);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    ASSERT_TRUE(Contains(outcome.out, "gps         32 of 32 fixes used")) << outcome.out;
    const json gps = json::parse(ReadText(run("on") / "run.json"))["gps"];
    EXPECT_EQ(gps["fixes"], 32);
    EXPECT_EQ(gps["used"], 32);
    EXPECT_EQ(gps["refused"], 0);
    // 0.05 m in two axes and 0.1 m in the third: 0.12 m.
    EXPECT_NEAR(gps["rms"].get<double>(), 0.12, 0.06);
    EXPECT_EQ(gps["T_GW"].size(), 7u);
  }
}

TEST_F(SlamWithGps, TheyCanBeLeftOut) {
  const Outcome outcome = Slam("off", "--gps off --imu off");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(Contains(outcome.out, "fixes"));
  EXPECT_FALSE(json::parse(ReadText(run("off") / "run.json")).contains("gps"));
  // The run behaves as if the file did not exist.
  fs::rename(dataset() / "gps.csv", folder_->path() / "gps.csv");
  const Outcome without = Slam("without", "--imu off");
  fs::rename(folder_->path() / "gps.csv", dataset() / "gps.csv");
  ASSERT_EQ(without.exit_code, 0) << without.err;
  for (const char* file : {"trajectory.txt", "keyframes.txt", "map.hwmap"}) {
    EXPECT_EQ(ReadText(run("off") / file), ReadText(run("without") / file)) << file;
  }
}

TEST_F(SlamWithGps, AFileThatIsWrongIsRefusedWithItsLine) {
  const std::string good = ReadText(dataset() / "gps.csv");
  WriteText(dataset() / "gps.csv", good + "12.5,1,2\n");
  const Outcome broken = Slam("broken", "");
  EXPECT_EQ(broken.exit_code, 2);
  EXPECT_TRUE(Contains(broken.err, "gps.csv:34: has 3 fields")) << broken.err;
  // The fixes are from another time: no frame has a fix, and the run continues without them.
  WriteText(dataset() / "gps.csv", "0.1,1,2,3\n0.2,1,2,4\n");
  const Outcome early = Slam("early", "--imu off");
  WriteText(dataset() / "gps.csv", good);
  EXPECT_EQ(early.exit_code, 0);
  EXPECT_TRUE(Contains(early.err, "warning: the GPS was not used")) << early.err;
}

TEST_F(SlamWithGps, TheAntennaIsThatOfTheBodyWhoseSensorIsUsed) {
  apps::RunConfig config;
  config.antenna_B = {1, 2, 3};
  EXPECT_EQ(apps::LoadGps(dataset(), config, false)->antenna_B, config.antenna_B);
  config.imu.emplace().T_BC = Pose::FromTangent({1, 0, 0}, {0, 0, 0});
  EXPECT_EQ(apps::LoadGps(dataset(), config, true)->antenna_B, config.antenna_B);
  EXPECT_EQ(apps::LoadGps(dataset(), config, false)->antenna_B, Eigen::Vector3d(0, 2, 3));
  EXPECT_FALSE(apps::LoadGps(folder_->path(), config, false));
}

TEST_F(SlamWithGps, TheSimulatorWritesFixesOfTheTruth) {
  simulate::SimulationOptions options = simulate::FieldTestOptions();
  options.duration = 100.0;
  const simulate::Simulation drive = simulate::SimulateDrive(options);
  WriteText(folder_->path() / "gps.csv", simulate::GpsCsv(drive, {.rate = 2.0, .sigma = 0.5}));
  const std::vector<GpsFix> fixes = ReadGps(folder_->path() / "gps.csv");
  ASSERT_EQ(fixes.size(), 200u);
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const GpsFix& fix : fixes) {
    EXPECT_EQ(fix.sigma, Eigen::Vector3d(0.5, 0.5, 1.0));
    const Eigen::Vector3d error =
        fix.p_G - simulate::GpsAlignment(drive) * (drive.T_WC(fix.stamp) * simulate::GpsAntenna());
    squares += error.cwiseQuotient(fix.sigma).cwiseAbs2() / 200.0;
  }
  // Statistic of 200 squares: 10 % of standard error.
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(squares(i), 1.0, 0.4);
}

}  // namespace
}  // namespace highwall::slam_gps_test
