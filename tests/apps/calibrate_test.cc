// Runs `highwall calibrate` on a generated recording with an IMU.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/frontend/calibration/camera_calibration.h>

#include "run/calibration_file.h"
#include "run/config.h"
#include "simulate/motion/recorded_motion.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/recorded_room.h"
#include "support/imu_scene.h"
#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::calibrate_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Outcome;

Outcome Calibrate(const std::string& options) {
  return testing::RunProgram(testing::kHighwallProgram, "calibrate " + options);
}

// Simulates the recording of a room by a camera on a body that rotates about all of its axes; its
// clock is 12 ms behind the clock of its IMU.
simulate::Simulation Recording(const std::function<void(simulate::SimulationOptions&)>& change =
                                   [](simulate::SimulationOptions&) {}) {
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
  change(options);
  return simulate::SimulateRecordedRoom(simulate::FitRecordedMotion(poses, readings), options);
}

// A factor that differs from the common one; the calibration states one 3 % too large, so depth is
// too short.
constexpr double kTrueFactor = 1000.0, kStatedFactor = 1030.0;

void WriteWithWrongFactor(const simulate::Simulation& recording, const fs::path& dataset) {
  simulate::WriteTum(recording, dataset);
  for (const auto& entry : fs::directory_iterator(dataset / "depth")) {
    cv::Mat depth = cv::imread(entry.path().string(), cv::IMREAD_UNCHANGED);
    depth.convertTo(depth, CV_16UC1, kTrueFactor / 5000.0);
    cv::imwrite(entry.path().string(), depth);
  }
  apps::RunConfig config = ReadSensor(dataset / "calibration.yaml");
  config.sensor.depth_factor = kStatedFactor;
  apps::WriteConfig(dataset / "calibration.yaml", config);
}

TEST(CalibrateCommand, FindsTheCameraOnTheImuAndWritesACalibrationThatIsReadBack) {
  const testing::TemporaryDirectory folder;
  const fs::path dataset = folder / "walk", written = folder / "new" / "found.yaml";
  const simulate::Simulation recording = Recording();
  const simulate::SimulationOptions& truth = recording.options();
  WriteWithWrongFactor(recording, dataset);
  const Outcome outcome = Calibrate(dataset.string() + " --json --out " + written.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_NEAR(report["time_offset_s"], truth.imu.time_offset, 1e-3);
  EXPECT_NEAR(report["depth_scale"], kStatedFactor / kTrueFactor, 0.01);
  const apps::RunConfig config = ReadSensor(written);
  ASSERT_TRUE(config.imu.has_value());
  const Pose error = truth.imu.T_BC.Inverse() * config.imu->T_BC;
  EXPECT_LT(error.Angle(), 0.3 * M_PI / 180.0);
  EXPECT_LT(error.p().norm(), 0.01);
  EXPECT_EQ(config.imu->noise.gyroscope, truth.imu.noise.gyroscope);
  EXPECT_NEAR(config.imu->rate, 200.0, 0.1);
  EXPECT_EQ(config.sensor.camera.fx, truth.camera.fx);
  EXPECT_EQ(config.imu->time_offset, report["time_offset_s"]);
  EXPECT_NEAR(config.sensor.depth_factor, kTrueFactor, 0.01 * kTrueFactor);

  // Uses existing poses, and a depth that is declared correct.
  const std::string poses = (dataset / "groundtruth.txt").string();
  const Outcome kept = Calibrate(dataset.string() + " --json --keep-depth --trajectory " + poses +
                                 " --out " + written.string());
  ASSERT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_NEAR(json::parse(kept.out)["time_offset_s"], truth.imu.time_offset, 3e-4);
  EXPECT_EQ(json::parse(kept.out)["depth_scale"], 1.0);
  EXPECT_EQ(ReadSensor(written).sensor.depth_factor, kStatedFactor);
}

TEST(CalibrateCommand, FindsIntrinsicsThatAreOffByOnePercent) {
  const testing::TemporaryDirectory folder;
  const fs::path dataset = folder / "walk", written = folder / "found.yaml";
  const simulate::Simulation recording = Recording();
  const PinholeCamera& truth = recording.options().camera;
  simulate::WriteTum(recording, dataset);
  apps::RunConfig config = ReadSensor(dataset / "calibration.yaml");
  config.sensor.camera.fx *= 1.01;
  config.sensor.camera.fy *= 1.01;
  apps::WriteConfig(dataset / "calibration.yaml", config);
  const Outcome outcome =
      Calibrate(dataset.string() + " --json --intrinsics --keep-depth --out " + written.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out)["intrinsics"];
  const PinholeCamera found = ReadSensor(written).sensor.camera;
  const std::vector<double> errors = {found.fx - truth.fx, found.fy - truth.fy, found.cx - truth.cx,
                                      found.cy - truth.cy};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    // Rendered pixels are accurate to a tenth, with errors of one sign over many frames.
    EXPECT_LT(std::abs(errors[i]), 0.003 * truth.fx) << i;
    EXPECT_GT(report["sigma_px"][i], 0.0);
    EXPECT_LT(report["sigma_px"][i], 0.003 * truth.fx);
  }
  testing::ExpectRefused(Calibrate(dataset.string() + " --intrinsics --trajectory x.txt"), 1,
                         {"--intrinsics", "--trajectory"});
}

// A camera that hardly rotates hardly constrains its principal point.
TEST(CalibrateCommand, IntrinsicsThatWereNotSeenStayAsTheyAreKnown) {
  const testing::TemporaryDirectory folder;
  const fs::path dataset = folder / "walk", written = folder / "found.yaml";
  simulate::SimulationOptions options = testing::SmallRoomOptions();
  options.duration = 2.2;
  options.fps = 10.0;
  options.imu.enabled = true;
  simulate::WriteTum(simulate::SimulateRoom(options), dataset);
  apps::RunConfig config = ReadSensor(dataset / "calibration.yaml");
  const PinholeCamera known = config.sensor.camera;
  const Outcome outcome =
      Calibrate(dataset.string() + " --json --intrinsics --keep-depth --out " + written.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out)["intrinsics"];
  const PinholeCamera kept = ReadSensor(written).sensor.camera;
  const double before[] = {known.fx, known.fy, known.cx, known.cy};
  const double after[] = {kept.fx, kept.fy, kept.cx, kept.cy};
  int unseen = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(report["seen"][i],
              report["sigma_px"][i] <= CameraCalibrationOptions().good_share * known.fx);
    if (report["seen"][i]) continue;
    ++unseen;
    EXPECT_EQ(after[i], before[i]) << i;
    EXPECT_NE(report["fx_fy_cx_cy"][i], before[i]) << "the estimate is reported all the same";
  }
  EXPECT_GE(unseen, 1) << report;
}

TEST(CalibrateCommand, EstimatesRowTimesAndWritesTheObservableOnes) {
  const testing::TemporaryDirectory folder;
  const fs::path dataset = folder / "walk", written = folder / "found.yaml";
  const simulate::Simulation recording = Recording([](simulate::SimulationOptions& options) {
    options.readout = 0.03;
    options.depth_readout = 0.03;
    options.depth_delay = 0.02;
  });
  simulate::WriteTum(recording, dataset);
  const Outcome outcome =
      Calibrate(dataset.string() + " --json --keep-depth --out " + written.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out), &times = report["row_times"];
  EXPECT_GT(report["rounds"], 2) << "what was found changes the map";
  EXPECT_LT(report["rounds"], 6) << "and settles";
  const FrameTiming found = ReadSensor(written).sensor.timing;
  // The stated value, 0, is kept unless the estimate differs by two standard deviations.
  const auto is_written = [&times](const char* key, double value) {
    const double value_s = times[key]["value_s"], sigma = times[key]["sigma_s"];
    const bool is_off = times[key]["seen"].get<bool>() && std::abs(value_s) > 2.0 * sigma;
    return value == (is_off ? value_s : 0.0);
  };
  EXPECT_TRUE(is_written("colour_readout", found.colour_readout)) << times;
  EXPECT_TRUE(is_written("depth_readout", found.depth_readout)) << times;
  EXPECT_TRUE(is_written("depth_delay", found.depth_delay)) << times;
  // The filter moves a third of the way in ninety frames, and the map keeps the rest: the values
  // converge only over several rounds. The remaining error is less than the last step.
  EXPECT_NEAR(found.colour_readout, 0.03, 0.002);
  EXPECT_NEAR(found.depth_delay, 0.02, 0.003);
  std::ifstream file(written);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find("# +- 0.0"), std::string::npos) << text;
}

TEST(CalibrateCommand, KeepsRowTimesThatItHasNotTracked) {
  const testing::TemporaryDirectory folder;
  const fs::path dataset = folder / "walk", written = folder / "found.yaml";
  const simulate::Simulation recording = Recording();
  simulate::WriteTum(recording, dataset);
  apps::RunConfig config = ReadSensor(dataset / "calibration.yaml");
  config.sensor.timing = {.colour_readout = 0.021, .depth_readout = 0.004, .depth_delay = -0.003};
  apps::WriteConfig(dataset / "calibration.yaml", config);
  const std::string poses = (dataset / "groundtruth.txt").string();
  const Outcome outcome =
      Calibrate(dataset.string() + " --json --trajectory " + poses + " --out " + written.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(json::parse(outcome.out).contains("row_times"));
  const FrameTiming kept = ReadSensor(written).sensor.timing;
  EXPECT_EQ(kept.colour_readout, 0.021);
  EXPECT_EQ(kept.depth_readout, 0.004);
  EXPECT_EQ(kept.depth_delay, -0.003);
}

TEST(CalibrateCommand, TakesARunByImagesAloneAndNoOther) {
  const testing::TemporaryDirectory folder;
  testing::WriteSmallRoom(folder / "room", 3);
  const fs::path run = folder / "run";
  fs::create_directory(run);
  const auto write = [&](const std::string& imu, const std::string& dataset) {
    std::ofstream(run / "run.json") << json{{"options", {{"imu", imu}}}, {"dataset", dataset}};
  };
  write("consistent", (folder / "room").string());
  testing::ExpectRefused(Calibrate(run.string()), 2, {"run.json", "--imu off"});
  write("off", (folder / "gone").string());
  testing::ExpectRefused(Calibrate(run.string()), 2, {"run.json", "gone", "not there"});
  // The poses of the run are of no use without an IMU.
  write("off", (folder / "room").string());
  testing::ExpectRefused(Calibrate(run.string()), 2, {(folder / "room").string(), "has no IMU"});
}

// A camera without an IMU that approaches and recedes; its depth reads 2 % too long at 3 m.
TEST(CalibrateCommand, FindsTheOffsetOfDepthWithoutAnImu) {
  const testing::TemporaryDirectory folder;
  const fs::path dataset = folder / "walk", written = folder / "found.yaml";
  const simulate::Simulation recording = Recording([](simulate::SimulationOptions& options) {
    options.imu.enabled = false;
    options.sensor.depth_bias = 0.02;
  });
  const double truth = recording.options().sensor.InverseDepthOffset();
  simulate::WriteTum(recording, dataset);
  const Outcome outcome = Calibrate(dataset.string() + " --json --out " + written.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_FALSE(report.contains("T_BC"));
  EXPECT_TRUE(report.contains("row_times"));
  const json found = report["inverse_depth_offset"];
  const double value = found["value_per_m"], sigma = found["sigma_per_m"];
  EXPECT_TRUE(found["seen"]);
  EXPECT_LT(sigma, 0.4 * std::abs(truth));
  EXPECT_LT(std::abs(value - truth), 3.0 * sigma) << value << " +- " << sigma << ", " << truth;
  const apps::RunConfig config = ReadSensor(written);
  EXPECT_EQ(config.sensor.inverse_depth_offset, std::abs(value) > 3.0 * sigma ? value : 0.0);
  EXPECT_FALSE(config.imu.has_value());

  // The estimate includes the stated offset, which is kept where depth is declared correct.
  apps::RunConfig stated = ReadSensor(dataset / "calibration.yaml");
  stated.sensor.inverse_depth_offset = truth;
  apps::WriteConfig(dataset / "calibration.yaml", stated);
  const std::string words = Calibrate(dataset.string()).out;
  EXPECT_NE(words.find("imu          none (imu.csv)"), std::string::npos) << words;
  EXPECT_NE(words.find("% too long at 3 m"), std::string::npos) << words;
  const Outcome again =
      Calibrate(dataset.string() + " --json --keep-depth --out " + written.string());
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const json same = json::parse(again.out)["inverse_depth_offset"];
  EXPECT_LT(std::abs(same["value_per_m"].get<double>() - truth), 3.0 * sigma) << same;
  EXPECT_EQ(ReadSensor(written).sensor.inverse_depth_offset, truth);
}

TEST(CalibrateCommand, FindsAPatternOfDepthOverTheImage) {
  const testing::TemporaryDirectory folder;
  const fs::path dataset = folder / "walk", written = folder / "found.yaml";
  const simulate::Simulation recording = Recording([](simulate::SimulationOptions& options) {
    options.imu.enabled = false;
    options.sensor.depth_pattern = 0.05;
  });
  const DepthPattern truth = recording.options().sensor.Pattern();
  simulate::WriteTum(recording, dataset);
  const Outcome outcome = Calibrate(dataset.string() + " --json --out " + written.string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json found = json::parse(outcome.out)["depth_pattern"];
  EXPECT_EQ(found["columns"].get<int>() * found["rows"].get<int>(), DepthPattern::kNodes);
  EXPECT_TRUE(found["seen"]);
  const DepthPattern pattern = ReadSensor(written).sensor.depth_pattern;
  EXPECT_EQ(found["values_per_m"].get<std::vector<double>>(),
            std::vector<double>(pattern.nodes.begin(), pattern.nodes.end()));
  DepthPattern left{pattern.nodes - truth.nodes};
  left.nodes.array() -= left.nodes.mean();  // the mean belongs to the offset
  // It is 0.32 here, six seconds at one place, and 0.12 to 0.24 in eight other recordings.
  EXPECT_LT(left.Rms(), 0.35 * truth.Rms());
  std::ifstream file(written);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find("pattern:  # +- 0.0"), std::string::npos) << text;

  const Outcome kept = Calibrate(dataset.string() + " --keep-depth --out " + written.string());
  EXPECT_NE(kept.out.find("pattern      "), std::string::npos) << kept.out;
  EXPECT_TRUE(ReadSensor(written).sensor.depth_pattern.IsZero());
}

// `highwall slam` estimates the depth distortion online.
TEST(SlamCommand, CorrectsADepthDistortionThatItFinds) {
  const testing::TemporaryDirectory folder;
  const fs::path dataset = folder / "walk";
  simulate::SimulationOptions options = testing::SmallRoomOptions();
  options.duration = 10.0;
  options.fps = 15.0;
  options.sensor.depth_pattern = 0.05;
  const DepthPattern truth = options.sensor.Pattern();
  simulate::WriteTum(simulate::SimulateRoom(options), dataset);
  const auto run = [&](const std::string& name, const std::string& more) {
    const Outcome outcome = testing::RunProgram(
        testing::kHighwallProgram, "slam --deterministic --no-map --dataset " + dataset.string() +
                                       " --out " + (folder / name).string() + more);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const double error = AbsolutePoseError(ReadTumTrajectory(dataset / "groundtruth.txt"),
                                           ReadTumTrajectory(folder / name / "trajectory.txt"))
                             .statistics.rmse;
    return std::pair(outcome.out, error);
  };
  const auto [words, corrected] = run("corrected", "");
  const auto [silent, as_it_is] = run("as_it_is", " --set depth_pattern.enabled=false");
  EXPECT_LT(corrected, 0.7 * as_it_is);
  EXPECT_NE(words.find("depth       correction of the distortion over the image: "), std::string::npos) << words;
  EXPECT_EQ(silent.find("correction of the distortion"), std::string::npos) << silent;
  std::ifstream file(folder / "corrected" / "run.json");
  const auto found = json::parse(file)["depth_pattern"]["values_per_m"].get<std::vector<double>>();
  ASSERT_EQ(found.size(), static_cast<std::size_t>(DepthPattern::kNodes));
  DepthPattern left;
  for (std::size_t i = 0; i < found.size(); ++i) {
    left.nodes[static_cast<Eigen::Index>(i)] = found[i] - truth.nodes[static_cast<Eigen::Index>(i)];
  }
  left.nodes.array() -= left.nodes.mean();  // a constant offset is not estimated
  EXPECT_LT(left.Rms(), 0.5 * truth.Rms());
}

TEST(CalibrateCommand, RefusesARecordingOfAMomentAndOneThatIsNone) {
  const testing::TemporaryDirectory folder;
  testing::WriteSmallRoom(folder / "room", 2);
  testing::ExpectRefused(Calibrate((folder / "room").string()), 2,
                         {(folder / "room").string(), "record for longer"});
  EXPECT_EQ(Calibrate((folder / "nowhere").string()).exit_code, 2);
  // A file name without a folder refers to the current folder.
  testing::ExpectRefused(Calibrate((folder / "room").string() + " --out found.yaml"), 2,
                         {"record for longer"});
  EXPECT_EQ(Calibrate("").exit_code, 1);
}

}  // namespace
}  // namespace highwall::calibrate_test
