#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "run/config.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/imu_scene.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::simulate::simulate_output_test {
namespace {

namespace fs = std::filesystem;
using highwall::testing::Outcome;
using highwall::testing::ReadText;
using highwall::testing::TemporaryDirectory;
using highwall::testing::WriteText;

SimulationOptions SmallOptions() {
  SimulationOptions options;
  options.camera = {.width = 160, .height = 120, .fx = 131.25, .fy = 131.5, .cx = 79.5, .cy = 59.5};
  options.duration = 0.2;
  return options;
}

std::ptrdiff_t CountEntries(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

Outcome Highwall(const std::string& arguments) {
  return testing::RunProgram(testing::kHighwallProgram, arguments);
}

TEST(WriteTum, TheProjectsOwnReaderFindsTheFramesAsTheyWereRendered) {
  const TemporaryDirectory folder;
  const Simulation simulation = SimulateRoom(SmallOptions());
  int reports = 0;
  WriteTum(simulation, folder.path() / "room", [&reports](int done, int total) {
    EXPECT_EQ(done, ++reports);
    EXPECT_EQ(total, 6);
  });
  EXPECT_EQ(reports, 6);
  const TumDataset dataset(folder.path() / "room");
  ASSERT_EQ(dataset.size(), 6u);
  for (int i = 0; i < simulation.size(); ++i) {
    const SimulatedFrame rendered = simulation.Render(i);
    const auto read = dataset.Load(static_cast<std::size_t>(i));
    ASSERT_TRUE(read.has_value());
    EXPECT_EQ(read->stamp, rendered.stamp);
    EXPECT_EQ(cv::norm(read->bgr, rendered.bgr, cv::NORM_INF), 0.0);
    // The tolerance is half a step plus the rounding of 3 m to a float.
    EXPECT_LE(cv::norm(read->depth, rendered.depth, cv::NORM_INF), 0.5 / kTumDepthFactor + 5e-7);
  }
}

TEST(WriteTum, TheTruthHoldsEveryFramesPoseAndAHundredASecond) {
  const TemporaryDirectory folder;
  const Simulation simulation = SimulateRoom(SmallOptions());
  WriteTum(simulation, folder.path() / "room");
  std::ifstream truth(folder.path() / "room" / "groundtruth.txt");
  std::string line;
  int frame = 0;
  Stamp last = 0;
  while (std::getline(truth, line)) {
    if (line[0] == '#') continue;
    std::istringstream words(line);
    std::string word;
    words >> word;
    const std::optional<Stamp> stamp = ParseStamp(word);
    ASSERT_TRUE(stamp.has_value()) << line;
    if (last != 0) {
      EXPECT_GT(*stamp, last);
      EXPECT_LE(*stamp - last, 10'000'000);
    }
    last = *stamp;
    std::array<double, Pose::kSize> block;
    for (double& value : block) ASSERT_TRUE(words >> value) << line;
    const Pose expected = simulation.T_WC(*stamp);
    for (std::size_t k = 0; k < block.size(); ++k) {
      EXPECT_NEAR(block[k], expected.data()[k], 1e-9);  // nine decimals
    }
    if (frame < simulation.size() && *stamp == simulation.StampOf(frame)) ++frame;
  }
  EXPECT_EQ(frame, simulation.size());
}

TEST(WriteTum, CalibrationReadsBackExactly) {
  const TemporaryDirectory folder;
  SimulationOptions options = SmallOptions();
  options.duration = 1.0 / options.fps;
  options.camera.k1 = 0.1 / 3.0;
  options.camera.p2 = -0.002;
  WriteTum(SimulateRoom(options), folder.path() / "room");
  const RgbdSensor sensor = ReadSensor(apps::CalibrationFile(folder.path() / "room")).sensor;
  EXPECT_EQ(sensor.camera.width, 160);
  EXPECT_EQ(sensor.camera.height, 120);
  EXPECT_EQ(sensor.camera.fx, 131.25);
  EXPECT_EQ(sensor.camera.fy, 131.5);
  EXPECT_EQ(sensor.camera.cx, 79.5);
  EXPECT_EQ(sensor.camera.cy, 59.5);
  EXPECT_EQ(sensor.camera.k1, 0.1 / 3.0);
  EXPECT_EQ(sensor.camera.p2, -0.002);
  EXPECT_EQ(sensor.depth_factor, 5000.0);
}

TEST(WriteTum, ImuReadsBackAsItWasSimulated) {
  const TemporaryDirectory folder;
  SimulationOptions options = SmallOptions();
  options.imu.time_offset = 0.02;
  const Simulation simulation = SimulateRoom(options);
  WriteTum(simulation, folder.path() / "room");
  const TumDataset dataset(folder.path() / "room");
  ASSERT_EQ(dataset.imu_file(), folder.path() / "room" / "imu.csv");
  const ImuRecording imu = ReadImu(*dataset.imu_file(), {dataset.stamp(0), dataset.stamp(5)});
  EXPECT_EQ(imu.warning, "");
  const std::vector<ImuSample> expected = simulation.ImuSamples();
  ASSERT_EQ(imu.samples.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(imu.samples[i].stamp, expected[i].stamp);
    // The file has nine decimals.
    EXPECT_LT((imu.samples[i].gyroscope - expected[i].gyroscope).norm(), 1e-9);
    EXPECT_LT((imu.samples[i].accelerometer - expected[i].accelerometer).norm(), 1e-9);
  }
}

TEST(WriteTum, TheTrueStatesAreThoseOfTheBodyInTheClockOfTheImu) {
  const TemporaryDirectory folder;
  SimulationOptions options = SmallOptions();
  options.imu.time_offset = 0.02;
  const Simulation simulation = SimulateRoom(options);
  WriteTum(simulation, folder.path() / "room");
  std::ifstream file(folder.path() / "room" / "groundtruth_state.csv");
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  EXPECT_TRUE(line.starts_with("#timestamp [ns],p_RS_R_x [m],")) << line;
  int states = 0;
  for (; std::getline(file, line); ++states) {
    std::istringstream text(line);
    Stamp stamp = 0;
    text >> stamp;
    std::array<double, 16> v{};
    char comma = 0;
    for (double& value : v) ASSERT_TRUE(text >> comma >> value) << line;
    const TrueState truth = simulation.StateAt(stamp - 20'000'000);
    const Pose T_WB(Eigen::Quaterniond(v[3], v[4], v[5], v[6]), {v[0], v[1], v[2]});
    EXPECT_LT((T_WB.Inverse() * truth.state.T_WB).p().norm(), 2e-9);
    EXPECT_LT((T_WB.Inverse() * truth.state.T_WB).Angle(), 4e-9);
    EXPECT_LT((Eigen::Vector3d(v[7], v[8], v[9]) - truth.state.v_WB).norm(), 1e-9);
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(v[10 + static_cast<std::size_t>(i)], truth.bias[i], 1e-9);
    }
    // The camera pose follows from T_BC.
    const Pose T_WC = truth.state.T_WB * options.imu.T_BC;
    EXPECT_LT((T_WC.Inverse() * simulation.T_WC(truth.stamp)).p().norm(), 1e-12);
  }
  EXPECT_EQ(states, 5 * 4 + 1);  // four a frame, which is 120 Hz
}

TEST(WriteTum, ImuCalibrationReadsBackExactly) {
  const TemporaryDirectory folder;
  SimulationOptions options = SmallOptions();
  options.duration = 1.0 / options.fps;
  options.imu.time_offset = 0.02;
  WriteTum(SimulateRoom(options), folder.path() / "room");
  const auto imu = ReadSensor(apps::CalibrationFile(folder.path() / "room")).imu;
  ASSERT_TRUE(imu.has_value());
  EXPECT_EQ(imu->T_BC.Matrix(), options.imu.T_BC.Matrix());
  EXPECT_EQ(imu->noise.gyroscope, options.imu.noise.gyroscope);
  EXPECT_EQ(imu->noise.accelerometer, options.imu.noise.accelerometer);
  EXPECT_EQ(imu->noise.gyroscope_walk, options.imu.noise.gyroscope_walk);
  EXPECT_EQ(imu->noise.accelerometer_walk, options.imu.noise.accelerometer_walk);
  EXPECT_EQ(imu->rate, 200.0);
  EXPECT_EQ(imu->time_offset, 0.0);  // the estimator has to estimate it
  EXPECT_TRUE(std::isinf(imu->accelerometer_range));
  // Of the faults, the data sheet states only the ranges.
  options.imu.faults = HardImuFaults();
  WriteTum(SimulateRoom(options), folder.path() / "hard");
  const auto hard = ReadSensor(apps::CalibrationFile(folder.path() / "hard")).imu;
  EXPECT_EQ(hard->accelerometer_range, options.imu.faults.accelerometer_range);
  EXPECT_EQ(hard->gyroscope_range, options.imu.faults.gyroscope_range);
}

TEST(WriteTum, CalibrationIsThatOfTheDataSheetsWhateverTheTruth) {
  const TemporaryDirectory folder;
  for (const double ratio : {1.0, 2.0}) {
    SimulationOptions options = SmallOptions();
    options.sensor.noise = SensorNoise::kKinect;
    options.sensor.noise_ratio = options.imu.noise_ratio = ratio;
    WriteTum(SimulateRoom(options), folder.path() / std::to_string(ratio));
  }
  const auto text = [&](double ratio, const char* name) {
    return ReadText(folder.path() / std::to_string(ratio) / name);
  };
  EXPECT_EQ(text(1.0, "calibration.yaml"), text(2.0, "calibration.yaml"));
  EXPECT_NE(text(1.0, "imu.csv"), text(2.0, "imu.csv"));
  const std::string depth =
      "depth/" + FormatStamp(SimulateRoom(SmallOptions()).StampOf(0)) + ".png";
  EXPECT_NE(text(1.0, depth.c_str()), text(2.0, depth.c_str()));
  const SimulationOptions usual;
  EXPECT_GT(usual.sensor.noise_ratio, 1.0) << "the files do not state the truth";
  EXPECT_GT(usual.imu.noise_ratio, 1.0);
}

TEST(WriteTum, SameSeedSameBytesOfTheImu) {
  const TemporaryDirectory folder;
  for (const char* name : {"a", "b"}) {
    WriteTum(SimulateRoom(SmallOptions()), folder.path() / name);
  }
  for (const char* name : {"imu.csv", "groundtruth_state.csv", "calibration.yaml"}) {
    const std::string text = ReadText(folder.path() / "a" / name);
    EXPECT_GT(text.size(), 100U) << name;
    EXPECT_EQ(text, ReadText(folder.path() / "b" / name)) << name;
  }
}

TEST(WriteTum, SurfaceIsTheMeshInBinaryPly) {
  const TemporaryDirectory folder;
  SimulationOptions options = SmallOptions();
  options.duration = 1.0 / options.fps;
  const Simulation simulation = SimulateRoom(options);
  WriteTum(simulation, folder.path() / "room");
  const Mesh& mesh = simulation.scene().mesh;
  const std::string ply = ReadText(folder.path() / "room" / "surface.ply");
  EXPECT_NE(ply.find("element vertex " + std::to_string(mesh.vertices.size()) + "\n"),
            std::string::npos);
  EXPECT_NE(ply.find("element face " + std::to_string(mesh.triangles.size()) + "\n"),
            std::string::npos);
  const std::string end = "end_header\n";
  const std::size_t body = ply.find(end) + end.size();
  EXPECT_EQ(ply.size() - body, 12 * mesh.vertices.size() + 13 * mesh.triangles.size());
}

TEST(WriteTum, LeavesAFolderThatHoldsSomethingAlone) {
  const TemporaryDirectory folder;
  WriteText(folder.path() / "mine.txt", "precious");
  EXPECT_THROW(WriteTum(SimulateRoom(SmallOptions()), folder.path()), IoError);
  EXPECT_EQ(ReadText(folder.path() / "mine.txt"), "precious");
  EXPECT_EQ(CountEntries(folder.path()), 1);
}

TEST(WriteTum, LeavesNothingBehindWhenItIsInterrupted) {
  const TemporaryDirectory folder;
  EXPECT_THROW(WriteTum(SimulateRoom(SmallOptions()), folder.path() / "room",
                        [](int, int) { throw std::runtime_error("stop"); }),
               std::runtime_error);
  EXPECT_EQ(CountEntries(folder.path()), 0);
}

// A process in another container may have the same process id.
TEST(WriteTum, SharesItsTemporaryWithNoProcessOfItsNumber) {
  const TemporaryDirectory folder;
  const fs::path other = folder.path() / (".room." + std::to_string(::getpid()));
  fs::create_directory(other);
  WriteText(other / "rgb.txt", "of another process");
  WriteTum(SimulateRoom(SmallOptions()), folder.path() / "room");
  EXPECT_EQ(ReadText(other / "rgb.txt"), "of another process");
  EXPECT_EQ(CountEntries(other), 1);
  EXPECT_EQ(CountEntries(folder.path()), 2);
}

TEST(SimulateCommand, WritesTheRoomIntoAnEmptyFolderToo) {
  const TemporaryDirectory folder;
  const Outcome run =
      Highwall("simulate room --duration 0.06 --noise off --out " + folder.path().string());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_EQ(CountEntries(folder.path() / "rgb"), 2);
  EXPECT_EQ(CountEntries(folder.path() / "depth"), 2);
}

TEST(SimulateCommand, LeavesTheImuOutOnRequest) {
  const TemporaryDirectory folder;
  const Outcome run =
      Highwall("simulate room --duration 0.03 --imu off --out " + folder.path().string());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_FALSE(fs::exists(folder.path() / "imu.csv"));
  EXPECT_FALSE(fs::exists(folder.path() / "groundtruth_state.csv"));
  EXPECT_FALSE(ReadSensor(apps::CalibrationFile(folder.path())).imu.has_value());
}

TEST(SimulateCommand, MovesTheClockOfTheImuAndIsStationaryAtFirst) {
  const TemporaryDirectory folder;
  const Outcome run = Highwall("simulate room --duration 0.03 --noise off --rest 1 " +
                               ("--time-offset -0.03 --out " + folder.path().string()));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const ImuRecording imu = ReadImu(folder.path() / "imu.csv", {1'000'000'000, 1'000'000'000});
  EXPECT_EQ(imu.samples.front().stamp, 440'000'000);  // 1 s - (0.5 + 0.03) s - 0.03 s
  for (const ImuSample& sample : imu.samples) EXPECT_EQ(sample.gyroscope.norm(), 0.0);
}

TEST(SimulateCommand, RecordsTheRoadWithADepthCameraInTheOpen) {
  const TemporaryDirectory folder;
  const fs::path road = folder.path() / "road";
  const Outcome run = Highwall("simulate road --duration 3 --fps 1 --scale 0.25 --blackout 1:0.5 " +
                               std::string("--rolling-shutter 30 --moving --out ") + road.string());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(CountEntries(road / "rgb"), 3);
  EXPECT_EQ(ReadText(road / "stretches.csv"),
            "#kind,begin [s],end [s]\nblackout,2.000000,2.500000\n");
  const RgbdSensor sensor = ReadSensor(apps::CalibrationFile(road)).sensor;
  EXPECT_EQ(sensor.camera.width, 160);
  EXPECT_EQ(sensor.camera.fx, 153.75);
  EXPECT_EQ(sensor.camera.cx, 79.5);  // the middle of the image is unchanged
  EXPECT_EQ(sensor.depth_factor, 1000.0);
  EXPECT_NEAR(sensor.depth_noise.Sigma(2.0), 0.08 * 4.0 / (425.0 * 0.05), 1e-12);
  const TumDataset dataset(road);
  ASSERT_EQ(dataset.size(), 3u);
  EXPECT_EQ(cv::countNonZero(dataset.Load(1)->depth), 0);  // the lens is covered
  EXPECT_GT(cv::countNonZero(dataset.Load(2)->depth), 160 * 120 / 3);
}

// Writes four seconds of a motion to two files.
void WriteRecording(const std::filesystem::path& poses, const std::filesystem::path& readings) {
  const SinusoidalMotion motion;
  Trajectory captured;
  std::ofstream imu(readings);
  imu.precision(12);
  for (const ImuSample& sample : motion.Samples(200.0, 4.0)) {
    captured.push_back({sample.stamp, motion.StateAt(ToSeconds(sample.stamp)).T_WB});
    imu << sample.stamp;
    for (const double w : sample.gyroscope) imu << ',' << w;
    for (const double a : sample.accelerometer) imu << ',' << a;
    imu << '\n';
  }
  WriteTumTrajectory(poses, captured);
}

TEST(SimulateCommand, FilmsTheRoomAlongARecordedMotionWithItsReadings) {
  const TemporaryDirectory folder;
  const std::string poses = (folder.path() / "motion.txt").string();
  const std::string readings = (folder.path() / "imu.csv").string();
  WriteRecording(poses, readings);
  const std::string command = "simulate room --scale 0.2 --trajectory " + poses + " --imu " +
                              readings + " --imu-noise 1e-4,1e-3,1e-5,1e-4 --out ";
  const Outcome run = Highwall(command + (folder.path() / "room").string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(testing::Contains(run.out, "motion and captured poses differ by 0.")) << run.out;
  const TumDataset dataset(folder.path() / "room");
  // 0.6 s before and after are reserved for the readings.
  EXPECT_NEAR(static_cast<double>(dataset.size()), 2.8 * 30.0, 2.0);
  const auto calibration = ReadSensor(apps::CalibrationFile(folder.path() / "room")).imu;
  ASSERT_TRUE(calibration.has_value());
  EXPECT_EQ(calibration->noise.gyroscope, 1e-4);
  const ImuRecording imu =
      ReadImu(folder.path() / "room" / "imu.csv", {dataset.stamp(0), dataset.stamp(0)});
  EXPECT_EQ(imu.samples.size(), 801U);

  WriteText(folder.path() / "one.txt", "1 0 0 0 0 0 0 1\n");
  testing::ExpectRefused(
      Highwall("simulate room --trajectory " + (folder.path() / "one.txt").string() + " --imu " +
               readings + " --out " + (folder.path() / "x").string()),
      2, {"one.txt", readings, "3.0"});
  for (const std::string& bad :
       {"simulate room --imu " + readings, "simulate room --trajectory " + poses,
        "simulate mine --trajectory " + poses + " --imu " + readings,
        "simulate room --moving --trajectory " + poses + " --imu " + readings,
        std::string("simulate room --imu-noise 1,1,1,1")}) {
    EXPECT_EQ(Highwall(bad + " --out " + (folder.path() / "x").string()).exit_code, 1) << bad;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "x"));
}

TEST(SimulateCommand, BlackoutsAndShuttersOutOfRangeAreUsageErrors) {
  const TemporaryDirectory folder;
  const std::string command = "simulate road --out " + (folder.path() / "x").string();
  for (const char* bad : {" --blackout 3", " --blackout 3:0", " --blackout x:1", " --blackout 3:1s",
                          " --rolling-shutter -1", " --scale 0", " --exposure long"}) {
    EXPECT_EQ(Highwall(command + bad).exit_code, 1) << bad;
  }
  EXPECT_EQ(CountEntries(folder.path()), 0);
}

TEST(SimulateCommand, DepthWithoutBiasIsOffByZeroAndNotByLessThanZero) {
  const TemporaryDirectory folder;
  const Outcome run = Highwall(
      "simulate room --duration 0.03 --scale 0.2 --depth-delay 0.02 --write-errors --out " +
      (folder.path() / "late").string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(ReadText(folder.path() / "late" / "calibration.yaml").find("  inverse_offset: 0\n"),
            std::string::npos);
}

TEST(SimulateCommand, WritesTheErrorsOfTheCameraOnRequest) {
  const TemporaryDirectory folder;
  const std::string errors =
      "simulate room --duration 0.03 --scale 0.2 --readout 0.03 --depth-delay 0.02 "
      "--depth-readout 0.025 --depth-bias 0.02 --out ";
  const auto calibration = [&](const std::string& name, const std::string& more) {
    const Outcome run = Highwall(errors + (folder.path() / name).string() + more);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return ReadText(folder.path() / name / "calibration.yaml");
  };
  const std::string silent = calibration("silent", "");
  EXPECT_EQ(silent.find("readout"), std::string::npos);
  EXPECT_EQ(calibration("stated", " --write-errors"),
            silent +
                "colour:\n  readout: 0.03\ndepth:\n  delay: 0.02\n  readout: 0.025\n"
                "  inverse_offset: -0.0065359477124183\n");
  calibration("pattern", " --write-errors --depth-pattern 0.03");
  const DepthPattern pattern =
      ReadSensor(folder.path() / "pattern" / "calibration.yaml").sensor.depth_pattern;
  EXPECT_LT((pattern.nodes - simulate::SensorOptions{.depth_pattern = 0.03}.Pattern().nodes).norm(),
            1e-12);
  for (const char* list : {"rgb.txt", "groundtruth.txt", "imu.csv"}) {
    EXPECT_EQ(ReadText(folder.path() / "silent" / list), ReadText(folder.path() / "stated" / list));
  }
}

TEST(SimulateCommand, ReadoutsOutOfRangeAreUsageErrorsThatStateTheLimit) {
  const TemporaryDirectory folder;
  const std::string command = "simulate room --out " + (folder.path() / "x").string();
  const auto refused = [&](const std::string& bad, const std::string& why) {
    const Outcome run = Highwall(command + bad);
    EXPECT_EQ(run.exit_code, 1) << bad;
    EXPECT_TRUE(testing::Contains(run.err, why)) << run.err;
  };
  refused(" --readout -0.01", "--readout: must be a number in [0 - 1], is -0.01");
  refused(" --readout 0.04",
          "--readout: must not take longer than the 0.03333 s from frame to frame, takes 0.04 s");
  refused(" --depth-readout 0.06 --fps 20",
          "--depth-readout: must not take longer than the 0.05 s from frame to frame");
  refused(" --rolling-shutter 100", "--rolling-shutter: must not take longer than the 0.03333 s");
  refused(" --rolling-shutter 10 --readout 0.01", "--readout excludes --rolling-shutter");
  refused(" --depth-delay 1", "--depth-delay: must be a number in [-0.2 - 0.2], is 1");
  refused(" --depth-bias 2", "--depth-bias: must be a number in [-0.1 - 0.1], is 2");
  EXPECT_EQ(CountEntries(folder.path()), 0);
}

TEST(SimulateCommand, RefusesToOverwriteWithOneLine) {
  const TemporaryDirectory folder;
  WriteText(folder.path() / "mine.txt", "precious");
  const Outcome run = Highwall("simulate room --out " + folder.path().string());
  testing::ExpectRefused(run, 2, {"not empty"});
}

TEST(SimulateCommand, TakesTheCameraOfACalibration) {
  const TemporaryDirectory folder;
  const auto calibration = folder.path() / "c.yaml";
  std::ofstream(calibration) << "camera: {width: 80, height: 60, fx: 50, fy: 51, cx: 39, cy: 30, "
                                "k1: 0.01, lens: equidistant}\ndepth_factor: 1000\n";
  const auto out = folder.path() / "room";
  ASSERT_EQ(Highwall("simulate room --duration 0.03 --camera " + calibration.string() + " --out " +
                     out.string())
                .exit_code,
            0);
  const PinholeCamera camera = ReadSensor(out / "calibration.yaml").sensor.camera;
  EXPECT_EQ(camera.width, 80);
  EXPECT_EQ(camera.fy, 51.0);
  EXPECT_EQ(camera.k1, 0.01);
  EXPECT_EQ(camera.lens, LensModel::kEquidistant);
}

TEST(SimulateCommand, UnknownScenesNoisesAndNumbersAreUsageErrors) {
  const TemporaryDirectory folder;
  const std::string out = " --out " + (folder.path() / "x").string();
  EXPECT_EQ(Highwall("simulate cave" + out).exit_code, 1);
  EXPECT_EQ(Highwall("simulate room --noise loud" + out).exit_code, 1);
  EXPECT_EQ(Highwall("simulate room --duration 0" + out).exit_code, 1);
  EXPECT_EQ(Highwall("simulate room --seed -1" + out).exit_code, 1);
  EXPECT_EQ(Highwall("simulate room --seed 99999999999999999999" + out).exit_code, 1);
  EXPECT_EQ(Highwall("simulate room --duration nan" + out).exit_code, 1);
  EXPECT_EQ(Highwall("simulate room --imu maybe" + out).exit_code, 1);
  EXPECT_EQ(Highwall("simulate room --time-offset 1" + out).exit_code, 1);
  EXPECT_EQ(Highwall("simulate room --rest -1" + out).exit_code, 1);
  EXPECT_EQ(Highwall("simulate room").exit_code, 1);
  EXPECT_EQ(CountEntries(folder.path()), 0);
}

}  // namespace
}  // namespace highwall::simulate::simulate_output_test
