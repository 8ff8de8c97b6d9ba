// --config with calibrations that other systems write, and highwall convert of them.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "run/calibration_file.h"
#include "run/config.h"
#include "run/opened_dataset.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/generated_tum.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::apps::foreign_config_test {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::Outcome;
using testing::ReadText;
using testing::TemporaryDirectory;
using testing::WriteText;

const std::string kOpen3d =
    R"({"width": 64, "height": 48, "intrinsic_matrix": [50,0,0,0,51,0,31,23,1]})";
const std::string kCameraInfo =
    "image_width: 64\nimage_height: 48\ncamera_matrix: {data: [50, 0, 31, 0, 51, 23, 0, 0, 1]}\n"
    "distortion_model: plumb_bob\n";
const std::string kOpencv =
    "%YAML:1.0\nimage_width: 64\nimage_height: 48\ncamera_matrix: !!opencv-matrix\n  rows: 3\n"
    "  cols: 3\n  data: [50, 0, 31, 0, 51, 23, 0, 0, 1]\n";
const std::string kKalibr =
    "cam0:\n  camera_model: pinhole\n  intrinsics: [50, 51, 31, 23]\n  resolution: [64, 48]\n";
const std::string kEuroc =
    "sensor_type: camera\nresolution: [64, 48]\ncamera_model: pinhole\n"
    "intrinsics: [50, 51, 31, 23]\ndistortion_model: radial-tangential\n"
    "distortion_coefficients: [0, 0, 0, 0]\n";
const std::string kOrbSlam =
    "%YAML:1.0\nCamera.type: \"PinHole\"\nCamera1.fx: 50\nCamera1.fy: 51\nCamera1.cx: 31\n"
    "Camera1.cy: 23\nCamera.width: 64\nCamera.height: 48\n";
const std::string kOrbSlamImu =
    "IMU.T_b_c1: !!opencv-matrix\n  rows: 4\n  cols: 4\n"
    "  data: [0, 0, 1, 0.5, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 1]\nIMU.NoiseGyro: 1e-3\n"
    "IMU.NoiseAcc: 2e-2\nIMU.GyroWalk: 3e-5\nIMU.AccWalk: 4e-4\n";
const std::string kOwn =
    "camera: {width: 64, height: 48, fx: 50, fy: 51, cx: 31, cy: 23}\ndepth_factor: 2500\n"
    "depth_range: {min: 0.3, max: 7}\ndepth_noise: {offset: 0.002}\n"
    "depth: {inverse_offset: -0.01}\nimu: {rate: 321, time_offset: 0.25, gyroscope_range: 8}\n";

class ForeignConfig : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) const {
    WriteText(folder_ / name, text);
    return (folder_ / name).string();
  }
  // Returns what WriteConfig() writes of a configuration.
  std::string TextOf(const RunConfig& config) const {
    WriteConfig(folder_ / "text.yaml", config);
    return ReadText(folder_ / "text.yaml");
  }
  Outcome Highwall(const std::string& arguments) const {
    return testing::RunProgram(testing::kHighwallProgram, arguments, folder_.path());
  }
  const TemporaryDirectory folder_;
};

TEST_F(ForeignConfig, TakesFromTheDatasetWhatTheFileDoesNotState) {
  const std::string own = Write("calibration.yaml", kOwn);
  for (const std::string& text : {kOpen3d, kCameraInfo, kOpencv, kKalibr, kEuroc, kOrbSlam}) {
    const std::string file = Write("foreign", text);
    const ResolvedConfig resolved = ResolveConfig(file, folder_.path());
    EXPECT_EQ(TextOf(resolved.config), TextOf(ReadSensor(own))) << text;
    EXPECT_EQ(resolved.origin, file);
    EXPECT_EQ(resolved.note, file + " is " + resolved.config.format +
                                 ", which does not state depth_factor, depth_range, depth_noise: "
                                 "they are those of " +
                                 own + " (depth_factor 2500)");
  }
  EXPECT_EQ(ResolveConfig(own, folder_.path()).note, "");
}

TEST_F(ForeignConfig, PrefersWhatTheFileStates) {
  Write("calibration.yaml", kOwn);
  const std::string file =
      Write("orb.yaml", kOrbSlam + kOrbSlamImu + "RGBD.DepthMapFactor: 4000\n");
  const ResolvedConfig resolved = ResolveConfig(file, folder_.path());
  const RunConfig& config = resolved.config;
  EXPECT_EQ(config.sensor.depth_factor, 4000.0);
  EXPECT_EQ(config.sensor.max_depth, 7.0);
  EXPECT_EQ(config.imu->T_BC.p().x(), 0.5);
  EXPECT_EQ(config.imu->noise.gyroscope, 1e-3);
  EXPECT_EQ(config.imu->rate, 321.0);
  EXPECT_EQ(config.imu->time_offset, 0.25);
  EXPECT_EQ(config.imu->gyroscope_range, 8.0);
  EXPECT_TRUE(Contains(resolved.note,
                       "does not state depth_range, depth_noise, imu: rate, imu: "
                       "time_offset: they are those of"))
      << resolved.note;
}

TEST_F(ForeignConfig, SaysWhatIsAssumedWhereNothingStatesIt) {
  const std::string file = Write("camchain.yaml", kKalibr);
  const ResolvedConfig resolved = ResolveConfig(file, folder_.path());
  EXPECT_EQ(resolved.config.sensor.depth_factor, 1000.0);
  EXPECT_EQ(resolved.note,
            file +
                " is a camera chain of Kalibr, which does not state depth_factor, depth_range, "
                "depth_noise: defaults are assumed (depth_factor 1000); to state them, edit "
                "what 'highwall convert " +
                file + " calibration.yaml' writes");
}

TEST_F(ForeignConfig, InTheFolderOfTheDatasetIsCompletedByThePresetOfItsName) {
  const fs::path dataset = folder_ / "rgbd_dataset_freiburg2_desk";
  fs::create_directory(dataset);
  WriteText(dataset / "calibration.yaml", kCameraInfo);
  for (const std::string& choice : {std::string(), (dataset / "calibration.yaml").string()}) {
    const ResolvedConfig resolved = ResolveConfig(choice, dataset);
    EXPECT_EQ(resolved.config.sensor.camera.fx, 50.0);
    EXPECT_EQ(resolved.config.sensor.depth_factor, 5208.0);
    EXPECT_TRUE(Contains(resolved.note, "those of preset tum2, by the dataset's name"))
        << resolved.note;
  }
}

TEST_F(ForeignConfig, TakesFromARecordingWhatItStatesItself) {
  testing::WriteTum(folder_.path());
  fs::rename(folder_ / "rgb", folder_ / "color");
  fs::remove(folder_ / "rgb.txt");
  fs::remove(folder_ / "depth.txt");
  Write("camera_intrinsic.json",
        R"({"width": 64, "height": 48, "intrinsic_matrix": [49,0,0,0,49,0,31,23,1],
            "depth_scale": 4000})");
  const OpenedDataset opened = OpenWithConfig(Write("info.yaml", kCameraInfo), folder_.path());
  EXPECT_EQ(opened.config.sensor.camera.fx, 50.0);
  EXPECT_EQ(opened.config.sensor.depth_factor, 4000.0);
  EXPECT_EQ(opened.images->Load(0)->depth.at<float>(5, 5), 1.25F);
  EXPECT_TRUE(Contains(opened.note, "those of camera_intrinsic.json (depth_factor 4000)"))
      << opened.note;
}

// A settings file of ORB-SLAM2 does not state the size of the images.
TEST_F(ForeignConfig, TakesTheSizeOfTheImagesWhereTheFileDoesNotStateIt) {
  const std::string orb2 =
      "%YAML:1.0\nCamera.fx: 50\nCamera.fy: 51\nCamera.cx: 31\nCamera.cy: 23\n"
      "DepthMapFactor: 5000.0\n";
  const std::string file = Write("orb.yaml", orb2);
  testing::WriteTum(folder_ / "tum", {.textured = true});
  const std::string note =
      "a settings file of ORB-SLAM (for 64 x 48, the size of the images), which does "
      "not state depth_range, depth_noise: defaults are assumed";
  const OpenedDataset opened = OpenWithConfig(file, folder_ / "tum");
  EXPECT_EQ(opened.config.sensor.camera.width, 64);
  EXPECT_EQ(opened.config.sensor.camera.height, 48);
  EXPECT_TRUE(Contains(opened.note, note)) << opened.note;
  EXPECT_TRUE(opened.images->Load(0));
  // For a camera, of live or of ROS.
  EXPECT_EQ(ResolveCameraConfig(file, cv::Size(80, 60)).config.sensor.camera.width, 80);
  // As calibration.yaml of the folder, for info and slam.
  WriteText(folder_ / "tum/calibration.yaml", orb2);
  EXPECT_EQ(ResolveConfig("", folder_ / "tum").config.sensor.camera.width, 64);
  const Outcome info = Highwall("info tum");
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_TRUE(Contains(info.out, note)) << info.out;
  // Without a recording the file must state it.
  testing::ExpectRefused(Highwall("convert orb.yaml out.yaml"), 2,
                         {"orb.yaml:2: Camera.width and Camera.height are missing: add"});
}

TEST_F(ForeignConfig, ConvertWritesItAsCalibrationYaml) {
  const std::string file = Write("orb.yaml", kOrbSlam + kOrbSlamImu);
  const Outcome outcome = Highwall("convert orb.yaml out/calibration.yaml");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err,
                       "orb.yaml is a settings file of ORB-SLAM, which does not state "
                       "depth_factor, depth_range"))
      << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "camera      64 x 48, fx 50, fy 51, cx 31, cy 23\n"));
  const fs::path written = folder_ / "out/calibration.yaml";
  EXPECT_TRUE(Contains(ReadText(written),
                       "depth_factor: 1000  # assumed: it is not stated by a settings file"))
      << ReadText(written);
  const RunConfig stated = ReadSensor(file), read = ReadSensor(written);
  EXPECT_EQ(read.format, "");
  EXPECT_EQ(read.sensor.camera.cy, stated.sensor.camera.cy);
  EXPECT_EQ(read.sensor.depth_noise.quadratic, stated.sensor.depth_noise.quadratic);
  EXPECT_EQ(read.imu->T_BC.Matrix(), stated.imu->T_BC.Matrix());
  EXPECT_EQ(read.imu->noise.accelerometer_walk, 4e-4);
}

TEST_F(ForeignConfig, ConvertRefusesToOverwriteItAndAConfigBesideIt) {
  Write("orb.yaml", kOrbSlam);
  testing::ExpectRefused(Highwall("convert orb.yaml orb.yaml"), 2,
                         {"orb.yaml: is the calibration that is read: choose another file"});
  testing::ExpectRefused(Highwall("convert orb.yaml out.yaml --config tum1"), 2,
                         {"orb.yaml: is a calibration, not a recording: leave --config out"});
  EXPECT_EQ(ReadText(folder_ / "orb.yaml"), kOrbSlam);
  EXPECT_EQ(folder_.FileCount(), 1U);
}

// Returns a line "key: [numbers]" of a calibration.yaml after its key.
std::string ValueOf(const std::string& text, const std::string& key) {
  const std::size_t begin = text.find(key + ": ") + key.size() + 2;
  return text.substr(begin, text.find_first_of("\n#", begin) - begin);
}

// Returns the settings of ORB-SLAM3 with the numbers of a calibration.yaml, to the last digit.
std::string OrbSlamOf(const std::string& own) {
  std::string text = "%YAML:1.0\nCamera.type: \"PinHole\"\n";
  for (const char* const key : {"fx", "fy", "cx", "cy"}) {
    text += "Camera1." + std::string(key) + ": " + ValueOf(own, key) + "\n";
  }
  text += "Camera.width: " + ValueOf(own, "width") + "\nCamera.height: " + ValueOf(own, "height") +
          "\nRGBD.DepthMapFactor: " + ValueOf(own, "depth_factor") +
          "\nIMU.NoiseGyro: " + ValueOf(own, "gyroscope_noise") +
          "\nIMU.NoiseAcc: " + ValueOf(own, "accelerometer_noise") +
          "\nIMU.GyroWalk: " + ValueOf(own, "gyroscope_walk") +
          "\nIMU.AccWalk: " + ValueOf(own, "accelerometer_walk") +
          "\nIMU.Frequency: " + ValueOf(own, "rate");
  const std::size_t begin = own.find("T_BC: ") + 6;
  return text + "\nIMU.T_b_c1: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: f\n   data: " +
         own.substr(begin, own.find(']', begin) + 1 - begin) + "\n";
}

TEST_F(ForeignConfig, GivesTheTrajectoryOfItsCalibrationYaml) {
  simulate::SimulationOptions options;
  options.camera = {
      .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
  options.fps = 6.0;
  options.duration = 1.5;
  simulate::WriteTum(simulate::SimulateRoom(options), folder_ / "room");
  const fs::path own = folder_ / "room/calibration.yaml";
  Write("orb.yaml", OrbSlamOf(ReadText(own)));
  fs::rename(own, folder_ / "own.yaml");
  const auto trajectory = [&](const std::string& config) {
    const Outcome outcome =
        Highwall("slam room --deterministic --no-map --overwrite --out run " + config);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(Contains(outcome.err, "highwall slam: orb.yaml is a settings file of ORB-SLAM"),
              config == "--config orb.yaml")
        << outcome.err;
    return ReadText(folder_ / "run/trajectory.txt");
  };
  const std::string expected = trajectory("--config own.yaml");
  const std::string stated = ReadText(folder_ / "orb.yaml");
  const std::size_t size = stated.find("Camera.width"), next = stated.find("RGBD.");
  Write("orb.yaml", stated.substr(0, size) + stated.substr(next));
  fs::copy_file(folder_ / "own.yaml", own);
  EXPECT_EQ(trajectory("--config orb.yaml"), expected);
}

}  // namespace
}  // namespace highwall::apps::foreign_config_test
