// Runs `highwall slam` on a room with an IMU and a depth camera that reads too long.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::slam_depth_scale_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Outcome;

// More than three standard deviations of an estimate from twenty seconds.
constexpr double kTooLong = 1.08;

class SlamDepthScale : public ::testing::Test {
 protected:
  void WriteSequence(double seconds, double rest) const {
    simulate::SimulationOptions options;
    options.camera = {
        .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
    options.fps = 12.0;
    options.duration = seconds;
    options.rest = rest;
    // So short a walk gives the scale to 2 % only if the noise matches the system's noise model.
    options.sensor.noise_ratio = options.imu.noise_ratio = 1.0;
    simulate::WriteTum(simulate::SimulateRoom(options), dataset());
  }
  // Changes the calibration so that the stored values yield depths that are too long.
  void Miscalibrate() const {
    const fs::path file = dataset() / "calibration.yaml";
    std::string text = testing::ReadText(file);
    const std::string key = "depth_factor: ";
    const std::size_t begin = text.find(key) + key.size(), end = text.find('\n', begin);
    const double factor = std::stod(text.substr(begin, end - begin));
    testing::WriteText(file, text.replace(begin, end - begin, std::to_string(factor / kTooLong)));
  }
  Outcome Slam() const {
    return testing::RunProgram(testing::kHighwallProgram,
                               "slam --no-map --no-loops --deterministic --dataset " +
                                   dataset().string() + " --out " + run().string());
  }
  json ImuReport() const { return json::parse(testing::ReadText(run() / "run.json"))["imu"]; }
  void ExpectScale(double truth) const {
    const json imu = ImuReport();
    ASSERT_TRUE(imu.contains("depth_scale")) << imu;
    const double sigma = imu["depth_scale"]["sigma"];
    EXPECT_LE(sigma, 0.02);
    EXPECT_NEAR(imu["depth_scale"]["value"].get<double>(), truth, 3.0 * sigma);
  }
  fs::path dataset() const { return folder_.path() / "dataset"; }
  fs::path run() const { return folder_.path() / "run"; }

 private:
  testing::TemporaryDirectory folder_;
};

TEST_F(SlamDepthScale, ReportsADepthThatReadsTooLongAndAdvises) {
  WriteSequence(20.0, 0.0);
  Miscalibrate();
  const Outcome bad = Slam();
  ASSERT_EQ(bad.exit_code, 0) << bad.err;
  ExpectScale(1.0 / kTooLong);
  EXPECT_NE(bad.err.find("% too long: set depth_factor: "), std::string::npos) << bad.err;
  EXPECT_NE(bad.out.find("\ndepth       scale 0.9"), std::string::npos) << bad.out;
}

TEST_F(SlamDepthScale, SaysNothingOfACameraAtRest) {
  WriteSequence(3.0, 3.0);
  Miscalibrate();
  const Outcome outcome = Slam();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(ImuReport().contains("initialized")) << ImuReport();
  EXPECT_FALSE(ImuReport().contains("depth_scale")) << ImuReport();
  EXPECT_EQ(outcome.err.find("depth reads"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace highwall::slam_depth_scale_test
