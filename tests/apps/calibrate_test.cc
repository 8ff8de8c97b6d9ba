// Runs `highwall calibrate` on a generated recording with an IMU.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>

#include "config.h"
#include "simulate/motion/recorded_motion.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/recorded_room.h"
#include "support/imu_scene.h"
#include "support/run_program.h"
#include "support/small_room.h"

namespace highwall {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::Outcome;

Outcome Calibrate(const std::string& options) {
  return testing::RunProgram(HIGHWALL_BINARY, "calibrate " + options);
}

// A room that is filmed by a camera on a body that turns about all of its axes, with a clock that
// is 12 ms behind its IMU's.
simulate::Simulation Recording() {
  const SinusoidalMotion motion(1.2);
  Trajectory poses;
  const std::vector<ImuSample> readings = motion.Samples(200.0, 7.5);
  for (const ImuSample& sample : readings) {
    poses.push_back({sample.stamp, motion.StateAt(ToSeconds(sample.stamp)).T_WB});
  }
  simulate::SimulationOptions options = testing::SmallRoomOptions();
  options.duration = 6.0;
  options.fps = 15.0;
  options.imu.enabled = true;
  options.imu.time_offset = 0.012;
  return simulate::SimulateRecordedRoom(simulate::FitRecordedMotion(poses, readings), options);
}

TEST(CalibrateCommand, FindsTheCameraOnTheImuAndWritesACalibrationThatIsReadBack) {
  const testing::TemporaryDirectory folder;
  const fs::path dataset = folder / "walk", written = folder / "found.yaml", run = folder / "run";
  const simulate::Simulation recording = Recording();
  const simulate::SimulationOptions& truth = recording.options();
  simulate::WriteTum(recording, dataset);
  const Outcome outcome = Calibrate(dataset.string() + " --json --out " + written.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_NEAR(report["time_offset_s"], truth.imu.time_offset, 1e-3);
  const apps::RunConfig config = apps::LoadConfig(written);
  ASSERT_TRUE(config.imu.has_value());
  const Pose error = truth.imu.T_BC.Inverse() * config.imu->T_BC;
  EXPECT_LT(error.Angle(), 0.3 * M_PI / 180.0);
  EXPECT_LT(error.p().norm(), 0.01);
  EXPECT_EQ(config.imu->noise.gyroscope, truth.imu.noise.gyroscope);
  EXPECT_EQ(config.sensor.camera.fx, truth.camera.fx);
  EXPECT_EQ(config.imu->time_offset, report["time_offset_s"]);

  // The same from poses that are there already.
  ASSERT_EQ(testing::RunProgram(HIGHWALL_BINARY, "slam --imu off --no-map --dataset " +
                                                     dataset.string() + " --out " + run.string())
                .exit_code,
            0);
  const Outcome of_run = Calibrate(run.string());
  ASSERT_EQ(of_run.exit_code, 0) << of_run.err;
  EXPECT_TRUE(Contains(of_run.out, "time offset  1")) << of_run.out;
}

TEST(CalibrateCommand, RefusesADatasetWithoutAnImuAndARunThatIsNone) {
  const testing::TemporaryDirectory folder;
  testing::WriteSmallRoom(folder / "room", 3);
  testing::ExpectRefused(Calibrate((folder / "room").string()), 2, {"has no IMU"});
  EXPECT_EQ(Calibrate((folder / "nowhere").string()).exit_code, 2);
  EXPECT_EQ(Calibrate("").exit_code, 1);
}

}  // namespace
}  // namespace highwall
