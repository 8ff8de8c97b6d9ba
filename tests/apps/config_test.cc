#include "run/config.h"

#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/input/sensor_profile.h>

#include "run/calibration_file.h"
#include "support/generated_tum.h"
#include "support/message_of.h"

namespace highwall::apps::config_test {
namespace {

using testing::MessageOf;
using testing::TemporaryDirectory;
using testing::WriteText;
using testing::WriteTum;

constexpr const char* kCamera =
    "camera: {width: 320, height: 240, fx: 260.5, fy: 261, cx: 159.5, cy: 120}\n";

// Returns the error message for a configuration file with this text, without its path.
std::string LoadMessage(const std::string& text) {
  const TemporaryDirectory folder;
  const std::string path = (folder.path() / "c.yaml").string();
  WriteText(path, text);
  const std::string message = MessageOf<IoError>([&] { ReadSensor(path); });
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_TRUE(message.starts_with(path)) << message;
  return message.substr(std::min(path.size(), message.size()));
}

TEST(Config, ReadsCameraDepthFactorAndNoise) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "c.yaml";
  WriteText(path, std::string(kCamera) + "depth_factor: 1000  # mm\ndepth_noise: {offset: 0.01}\n");
  const RgbdSensor sensor = ReadSensor(path).sensor;
  EXPECT_EQ(sensor.camera.width, 320);
  EXPECT_EQ(sensor.camera.fx, 260.5);
  EXPECT_EQ(sensor.camera.cy, 120.0);
  EXPECT_FALSE(sensor.camera.HasDistortion());
  EXPECT_EQ(sensor.depth_factor, 1000.0);
  EXPECT_EQ(sensor.depth_noise.offset, 0.01);
  EXPECT_EQ(sensor.depth_noise.quadratic, DepthNoise{}.quadratic);
}

TEST(Config, ReadsWhenTheRowsOfTheImagesAreTaken) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "c.yaml";
  const std::string start = std::string(kCamera) + "depth_factor: 1000\n";
  WriteText(path, start);
  EXPECT_EQ(ReadSensor(path).sensor.timing.colour_readout, 0.0);
  WriteText(path, start +
                      "colour: {readout: 0.026}\ndepth: {delay: -0.004, readout: 0.01, "
                      "inverse_offset: -0.0065}\n");
  const FrameTiming timing = ReadSensor(path).sensor.timing;
  EXPECT_EQ(timing.direction, ReadoutDirection::kDown);
  EXPECT_EQ(timing.colour_readout, 0.026);
  EXPECT_EQ(timing.depth_readout, 0.01);
  EXPECT_EQ(timing.depth_delay, -0.004);
  EXPECT_EQ(ReadSensor(path).sensor.inverse_depth_offset, -0.0065);
  EXPECT_TRUE(ReadSensor(path).sensor.depth_pattern.IsZero());
  WriteText(path, start + "depth:\n  pattern: [1,2,3]\n");
  EXPECT_NE(MessageOf<IoError>([&] {
              ReadSensor(path);
            }).find(":4: 'pattern' must be a list of 20 finite numbers"),
            std::string::npos)
      << MessageOf<IoError>([&] { ReadSensor(path); });
  const auto message = [&](const std::string& lines) {
    WriteText(path, start + lines);
    return MessageOf<IoError>([&] { ReadSensor(path); });
  };
  const auto says = [&](const std::string& lines, const std::string& words) {
    const std::string text = message(lines);
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  says("depth:\n  pattern: [3,0,0,0,0, 0,0,0,0,0, 0,0,0,0,0, 0,0,0,0,0]\n",
       ":4: depth: pattern must be within 1 / m");
  says("depth:\n  inverse_offset: 2\n", ":4: depth: inverse_offset must be within 1 / m");
  says("depth:\n  readout: -2\n", ":4: depth: readout must");
  says("colour:\n  readout: -2\n", ":4: colour: readout must");
  says("depth_range:\n  max: 0.01\n", ":4: depth_range: max must exceed");
  WriteText(path, start + "colour: {readout: -0.01}\n");
  EXPECT_THROW(ReadSensor(path), IoError);
  WriteText(path, start + "colour: {direction: left}\n");
  EXPECT_EQ(ReadSensor(path).sensor.timing.direction, ReadoutDirection::kLeft);
  says(
      "colour:\n  direction: sideways\n",
      ":4: 'direction' must be down, up, right or left: where the read-out goes, found 'sideways'");
  WriteText(path, start + "colour: {read_out: 0.01}\n");
  EXPECT_THROW(ReadSensor(path), IoError);
}

TEST(Config, ReadsTheNoiseOfAStereoSensor) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "c.yaml";
  const std::string start = std::string(kCamera) + "depth_factor: 1000\ndepth_noise: ";
  WriteText(path, start + "{baseline: 0.05, focal: 385, subpixel: 0.1}\n");
  const DepthNoise given = ReadSensor(path).sensor.depth_noise;
  EXPECT_NEAR(given.Sigma(1.5), 0.1 * 1.5 * 1.5 / (385.0 * 0.05), 1e-12);
  WriteText(path, start + "{baseline: 0.05, focal: 385}\n");
  const DepthNoise usual = ReadSensor(path).sensor.depth_noise;
  EXPECT_NEAR(usual.Sigma(1.5), DepthNoise::Stereo(0.08, 385.0, 0.05).Sigma(1.5), 1e-12);
  // The two alternatives exclude each other.
  const auto message = [&](const std::string& noise) { return LoadMessage(start + noise + "\n"); };
  EXPECT_NE(message("{baseline: 0.05}").find("focal"), std::string::npos);
  EXPECT_NE(message("{baseline: 0.05, focal: -1}").find("focal"), std::string::npos);
  EXPECT_NE(message("{baseline: 0.05, focal: 385, offset: 0.01}").find("offset"),
            std::string::npos);
}

TEST(Config, TakesRangeFactorAndNoiseFromANamedSensor) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "c.yaml";
  WriteText(path, "sensor: d435\n" + std::string(kCamera));
  const RgbdSensor named = ReadSensor(path).sensor;
  const RgbdSensor profile = FindSensorProfile("d435")->SensorFor(named.camera);
  EXPECT_EQ(named.camera.fx, 260.5);
  EXPECT_EQ(named.depth_factor, 1000.0);
  EXPECT_EQ(named.min_depth, profile.min_depth);
  EXPECT_EQ(named.max_depth, profile.max_depth);
  EXPECT_EQ(named.depth_noise.quadratic, profile.depth_noise.quadratic);
}

TEST(Config, TheFileOverridesTheSensor) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "c.yaml";
  WriteText(path, std::string(kCamera) +
                      "sensor: l515\ndepth_factor: 1000\ndepth_range: {max: 4.5}\n"
                      "depth_noise: {offset: 0.01}\n");
  const RgbdSensor sensor = ReadSensor(path).sensor;
  EXPECT_EQ(sensor.depth_factor, 1000.0);
  EXPECT_EQ(sensor.min_depth, 0.25);
  EXPECT_EQ(sensor.max_depth, 4.5);
  EXPECT_EQ(sensor.depth_noise.offset, 0.01);
  EXPECT_EQ(sensor.depth_noise.quadratic, FindSensorProfile("l515")->noise.quadratic);
}

TEST(Config, WithoutASensorTheRangeIsWide) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "c.yaml";
  WriteText(path, std::string(kCamera) + "depth_factor: 1000\n");
  EXPECT_EQ(ReadSensor(path).sensor.min_depth, 0.05);
  EXPECT_EQ(ReadSensor(path).sensor.max_depth, 20.0);
}

TEST(Config, NamesAnUnknownSensorAndABadRange) {
  const std::string camera = kCamera;
  EXPECT_EQ(LoadMessage(camera + "sensor: d436\n"),
            ": the sensor 'd436' is unknown; known are " + SensorProfileList());
  EXPECT_NE(LoadMessage(camera).find("depth_factor"), std::string::npos);
  const std::string head = camera + "depth_factor: 1000\n";
  EXPECT_NE(LoadMessage(head + "depth_range: {min: 0}\n").find("depth_range: min"),
            std::string::npos);
  EXPECT_NE(LoadMessage(head + "depth_range: {max: 0.01}\n").find("depth_range: max"),
            std::string::npos);
  EXPECT_NE(LoadMessage(head + "depth_range: {near: 0.1}\n").find("near"), std::string::npos);
}

TEST(Config, ReadsTheDistortion) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "c.yaml";
  WriteText(path,
            "depth_factor: 5000\ncamera:\n  width: 640\n  height: 480\n  fx: 500\n  fy: 500\n"
            "  cx: 320\n  cy: 240\n  k1: 0.1\n  k2: -0.2\n  p1: 0.003\n  p2: 0.004\n  k3: 0.5\n");
  const PinholeCamera camera = ReadSensor(path).sensor.camera;
  EXPECT_EQ(camera.k1, 0.1);
  EXPECT_EQ(camera.k2, -0.2);
  EXPECT_EQ(camera.p1, 0.003);
  EXPECT_EQ(camera.p2, 0.004);
  EXPECT_EQ(camera.k3, 0.5);
}

TEST(Config, ReadsAnImu) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "c.yaml";
  const std::string camera = std::string(kCamera) + "depth_factor: 1000\n";
  WriteText(path, camera);
  EXPECT_FALSE(ReadSensor(path).imu.has_value());
  WriteText(path, camera + "imu: {}\n");
  ASSERT_TRUE(ReadSensor(path).imu.has_value());
  EXPECT_EQ(ReadSensor(path).imu->T_BC.Matrix(), Eigen::Matrix4d::Identity());
  EXPECT_EQ(ReadSensor(path).imu->noise.gyroscope, ImuNoise{}.gyroscope);
  WriteText(path, camera +
                      "imu:\n  T_BC: [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n"
                      "  gyroscope_noise: 1e-3\n  accelerometer_noise: 2e-3\n"
                      "  gyroscope_walk: 3e-5\n  accelerometer_walk: 4e-4\n"
                      "  rate: 250\n  time_offset: -0.01\n"
                      "  gyroscope_range: 8.7\n  accelerometer_range: 39.2\n");
  const ImuCalibration imu = ReadSensor(path).imu.value();
  EXPECT_EQ(imu.T_BC.p(), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_LT((imu.T_BC * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.1, 1.2, 0.3)).norm(), 1e-15);
  EXPECT_EQ(imu.noise.gyroscope, 1e-3);
  EXPECT_EQ(imu.noise.accelerometer, 2e-3);
  EXPECT_EQ(imu.noise.gyroscope_walk, 3e-5);
  EXPECT_EQ(imu.noise.accelerometer_walk, 4e-4);
  EXPECT_EQ(imu.rate, 250.0);
  EXPECT_EQ(imu.time_offset, -0.01);
  EXPECT_EQ(imu.gyroscope_range, 8.7);
  EXPECT_EQ(imu.accelerometer_range, 39.2);
}

TEST(Config, NamesTheFaultOfAnImu) {
  const std::string head = std::string(kCamera) + "depth_factor: 1000\n";
  EXPECT_EQ(LoadMessage(head + "imu: {gyro_noise: 1}\n"),
            ":3: unknown key 'gyro_noise'; did you mean 'gyroscope_noise'?");
  EXPECT_EQ(LoadMessage(head + "imu: {T_BC: [1, 2]}\n"),
            ":3: 'T_BC' must be a list of 16 finite numbers");
  EXPECT_EQ(LoadMessage(head + "imu: {T_BC: 1}\n"),
            ":3: 'T_BC' must be a list of 16 finite numbers");
  EXPECT_EQ(LoadMessage(head + "imu: {T_BC: [1,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1]}\n"),
            ": 'T_BC' of section 'imu' must end with 0, 0, 0, 1: write it row by row");
  EXPECT_NE(
      LoadMessage(head + "imu: {T_BC: [2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}\n").find("rotation"),
      std::string::npos);
  EXPECT_NE(LoadMessage(head + "imu: {rate: 0}\n").find(":3: imu: rate must be positive"),
            std::string::npos)
      << LoadMessage(head + "imu: {rate: 0}\n");
  EXPECT_NE(LoadMessage(head + "imu: {time_offset: 30}\n").find(":3: imu: time_offset must"),
            std::string::npos);
  EXPECT_NE(LoadMessage(head + "imu: {gyroscope_walk: -1}\n").find(":3: imu: gyroscope_walk"),
            std::string::npos);
  EXPECT_NE(LoadMessage(std::string(kCamera) + "\ndepth_factor: 0\n").find(":3: depth_factor"),
            std::string::npos);
}

TEST(Config, RefusesRangesOfAnImuThatAreNoneInItsUnits) {
  const std::string head = std::string(kCamera) + "\ndepth_factor: 5000\n";
  const auto message = [&head](const std::string& line) {
    return LoadMessage(head + "imu:\n  rate: 200\n  " + line + "\n");
  };
  for (const char* line : {"accelerometer_range: 0", "accelerometer_range: 4"}) {
    const std::string text = message(line);
    EXPECT_NE(text.find(":6: imu: accelerometer_range must be at least 9.80665 m/s^2"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("; 1 g is 9.80665 m/s^2"), std::string::npos) << text;
  }
  for (const char* line : {"gyroscope_range: 0", "gyroscope_range: 250"}) {
    const std::string text = message(line);
    EXPECT_NE(text.find(":6: imu: gyroscope_range must be positive and at most 70 rad/s"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("; 1 deg/s is 0.0174533 rad/s"), std::string::npos) << text;
  }
}

TEST(Config, NamesAnUnknownKeyItsLineAndTheNearestKnownOne) {
  EXPECT_EQ(LoadMessage(std::string(kCamera) + "\ndepth_facter: 5000\n"),
            ":3: unknown key 'depth_facter'; did you mean 'depth_factor'?");
  EXPECT_EQ(LoadMessage("depth_factor: 5000\ncamera:\n  width: 640\n  hieght: 480\n"),
            ":4: unknown key 'hieght'; did you mean 'height'?");
  EXPECT_EQ(LoadMessage("depth_factor: 5000\ncamra: {width: 640}\n"),
            ":2: unknown key 'camra'; did you mean 'camera'?");
}

TEST(Config, ReadsRationalLensesAndFisheyesAndNamesOthers) {
  const auto with = [](const std::string& more) {
    return "depth_factor: 5000\ncamera:\n  {width: 320, height: 240, fx: 260, fy: 261, cx: 159,\n"
           "   cy: 120, k1: 0.1, " +
           more + "}\n";
  };
  EXPECT_EQ(LoadMessage(with("s1: 0.1")),
            ":4: camera: s1 is of a lens with a thin prism, which is not known: calibrate with k1 "
            "to k6, p1 and p2, or undistort the images");
  EXPECT_EQ(LoadMessage(with("lens: fisheye")),
            ":4: camera: lens must be radial_tangential (k1, k2, p1, p2, k3, and k4 to k6 of a "
            "rational model) or equidistant (k1 to k4 of a fisheye), not fisheye");
  const TemporaryDirectory folder;
  const auto path = folder.path() / "c.yaml";
  WriteText(path, with("k4: 0.2, k5: 0.3, k6: 0.4, s1: 0"));
  const PinholeCamera rational = ReadSensor(path).sensor.camera;
  EXPECT_EQ(rational.k4, 0.2);
  EXPECT_EQ(rational.k6, 0.4);
  EXPECT_EQ(rational.lens, LensModel::kRadialTangential);
  WriteText(path, with("k4: 0.2, lens: equidistant"));
  EXPECT_EQ(ReadSensor(path).sensor.camera.lens, LensModel::kEquidistant);
}

TEST(Config, NamesTheCalibrationOfAnotherSystemAndHowOursIsWritten) {
  struct Case {
    const char *text, *name, *words;
  };
  for (const Case& c :
       {Case{"{\"width\": 640, \"height\": 480, \"ppx\": 320.1, \"ppy\": 239.2, \"fx\": 615.0}",
             "the intrinsics of librealsense", "cx and cy its ppx and ppy"},
        Case{"%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n", "a file of OpenCV's FileStorage",
             "camera matrix"}}) {
    const std::string message = LoadMessage(c.text);
    EXPECT_TRUE(message.starts_with(": is " + std::string(c.name))) << message;
    EXPECT_NE(message.find(", which is not read; write 'camera: {width: 640, height: 480, fx: 525"),
              std::string::npos)
        << message;
    EXPECT_NE(message.find(c.words), std::string::npos) << message;
  }
  const std::string ours = std::string("# once camera_matrix: and image_width: of ROS\n") + kCamera;
  EXPECT_EQ(LoadMessage(ours), ": key 'depth_factor' is missing");
}

TEST(Config, NamesAMissingKey) {
  EXPECT_EQ(LoadMessage(kCamera), ": key 'depth_factor' is missing");
  EXPECT_EQ(LoadMessage("depth_factor: 5000\n"), ": key 'width' is missing from section 'camera'");
}

TEST(Config, NamesAKeyThatIsThereTwice) {
  EXPECT_EQ(LoadMessage("depth_factor: 1\ndepth_factor: 2\n" + std::string(kCamera)),
            ":2: key 'depth_factor' is there twice");
}

TEST(Config, NamesAValueOfTheWrongType) {
  const std::string camera = kCamera;
  EXPECT_EQ(LoadMessage(camera + "depth_factor: big\n"),
            ":2: 'depth_factor' must be a finite number, found 'big'");
  EXPECT_EQ(LoadMessage(camera + "depth_factor: .nan\n"),
            ":2: 'depth_factor' must be a finite number, found '.nan'");
  EXPECT_EQ(LoadMessage(camera + "depth_factor: [1, 2]\n"),
            ":2: 'depth_factor' must be a finite number, found no single value");
  EXPECT_EQ(LoadMessage(camera + "depth_factor:\n"),
            ":2: 'depth_factor' must be a finite number, found no single value");
  EXPECT_EQ(LoadMessage("camera: {width: 640.5}\n"),
            ":1: 'width' must be an integer, found '640.5'");
  EXPECT_EQ(LoadMessage("depth_factor: 1\ncamera: 3\n"),
            ":2: 'camera' must be a section of 'key: value' lines");
}

TEST(Config, NamesAValueOutOfRange) {
  const std::string message = LoadMessage(std::string(kCamera) + "depth_factor: -5\n");
  EXPECT_NE(message.find("depth_factor must be positive"), std::string::npos) << message;
}

TEST(Config, RefusesFilesThatAreNoYamlMap) {
  EXPECT_TRUE(LoadMessage("camera: {width: 3\n").find("is not YAML") != std::string::npos);
  EXPECT_EQ(LoadMessage(""), ": holds no 'key: value' lines");
  EXPECT_EQ(LoadMessage("just words\n"), ": holds no 'key: value' lines");
  EXPECT_EQ(MessageOf<IoError>([] { ReadSensor("/nowhere/c.yaml"); }),
            "/nowhere/c.yaml: is missing or cannot be read");
}

TEST(ResolveConfig, TakesAPresetByName) {
  EXPECT_EQ(ResolveConfig("tum2", "/nowhere").config.sensor.depth_factor, 5208.0);
}

TEST(ResolveConfig, PrefersTheOptionThenCalibrationYamlThenTheName) {
  const TemporaryDirectory folder;
  const auto dataset = folder.path() / "rgbd_dataset_freiburg2_desk";
  std::filesystem::create_directories(dataset);
  EXPECT_EQ(ResolveConfig("", dataset).config.sensor.camera.fx, 520.9);
  EXPECT_EQ(ResolveConfig("", dataset).origin, "preset tum2, by the dataset's name");
  WriteText(dataset / "calibration.yaml", std::string(kCamera) + "depth_factor: 1000\n");
  EXPECT_EQ(ResolveConfig("", dataset).config.sensor.camera.fx, 260.5);
  EXPECT_EQ(ResolveConfig("", dataset).origin, (dataset / "calibration.yaml").string());
  EXPECT_EQ(ResolveConfig("tum3", dataset).config.sensor.camera.fx, 535.4);
  const std::string file = (dataset / "calibration.yaml").string();
  EXPECT_EQ(ResolveConfig(file, "/nowhere").config.sensor.camera.fx, 260.5);
}

TEST(ResolveConfig, AdvisesWhereNothingIsKnown) {
  const TemporaryDirectory folder;
  EXPECT_EQ(MessageOf<IoError>([&] { ResolveConfig("", folder.path()); }),
            folder.path().string() + ": is empty");
  WriteTum(folder.path());
  EXPECT_EQ(MessageOf<IoError>([&] { ResolveConfig("", folder.path()); }),
            folder.path().string() +
                ": the camera is unknown: put calibration.yaml there, or give --config with a "
                "file or one of tum1, tum2, tum3");
  EXPECT_EQ(MessageOf<IoError>([&] { ResolveConfig("tum9", folder.path()); }),
            "tum9: is neither a file nor a preset (tum1, tum2, tum3); did you mean 'tum1'?");
}

TEST(PresetFromName, KnowsFreiburgByFolderAndByTheListsComment) {
  EXPECT_EQ(PresetFromName("/data/rgbd_dataset_freiburg1_xyz/"), "tum1");
  EXPECT_EQ(PresetFromName("/data/fr3_office"), "tum3");
  EXPECT_EQ(PresetFromName("/freiburg1/desk"), "");
  EXPECT_EQ(PresetFromName("/data/fr10"), "");
  EXPECT_EQ(PresetFromName("/data/xfr1_a"), "");
  const TemporaryDirectory folder;
  WriteText(folder.path() / "rgb.txt", "# color\n# file: 'rgbd_dataset_freiburg2_a.bag'\n1.0 a\n");
  EXPECT_EQ(PresetFromName(folder.path()), "tum2");
}

TEST(WriteConfig, IsReadBack) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "c.yaml";
  RunConfig config;
  config.sensor.camera.fx = 1517.3 / 3.0;
  config.sensor.camera.k3 = -1e-7;
  config.sensor.depth_factor = 1000.0 / 0.97;
  config.sensor.min_depth = 0.1;
  config.sensor.depth_noise = DepthNoise::Stereo(0.1, 400.0, 0.055);
  config.sensor.inverse_depth_offset = -0.02 / 3.06;
  for (int i = 0; i < DepthPattern::kNodes; ++i) {
    config.sensor.depth_pattern.nodes[i] = 0.01 * std::sin(i);
  }
  config.sensor.camera.k6 = 0.3;
  DepthCameraCalibration& depth = config.sensor.depth_camera.emplace();
  depth.camera = {.width = 424, .height = 240, .fx = 213.0, .fy = 212.0, .cx = 211.5, .cy = 119.0};
  depth.camera.k4 = -0.02;
  depth.camera.lens = LensModel::kEquidistant;
  depth.T_CD = Pose::FromTangent({0.0, 0.01, 0.02}, {0.015, 1.0 / 3000.0, 0.0});
  config.imu.emplace();
  config.imu->T_BC = Pose::FromTangent({0.01, 1.0 / 3.0, -0.2}, {0.3, -1.1, 2.0});
  config.imu->noise.gyroscope_walk = 1.0 / 30'001.0;
  config.imu->time_offset = -0.0123456789;
  config.imu->accelerometer_range = 4.0 * 9.80665;
  WriteConfig(path, config);
  const RunConfig read = ReadSensor(path);
  EXPECT_EQ(read.sensor.camera.fx, config.sensor.camera.fx);
  EXPECT_EQ(read.sensor.camera.k6, 0.3);
  ASSERT_TRUE(read.sensor.depth_camera);
  EXPECT_EQ(read.sensor.depth_camera->camera.cx, depth.camera.cx);
  EXPECT_EQ(read.sensor.depth_camera->camera.k4, depth.camera.k4);
  EXPECT_EQ(read.sensor.depth_camera->camera.lens, LensModel::kEquidistant);
  EXPECT_TRUE(read.sensor.depth_camera->T_CD.Matrix().isApprox(depth.T_CD.Matrix(), 1e-14));
  EXPECT_EQ(read.sensor.camera.k3, config.sensor.camera.k3);
  EXPECT_EQ(read.sensor.depth_factor, config.sensor.depth_factor);
  EXPECT_EQ(read.sensor.min_depth, config.sensor.min_depth);
  EXPECT_EQ(read.sensor.depth_noise.quadratic, config.sensor.depth_noise.quadratic);
  EXPECT_EQ(read.sensor.inverse_depth_offset, config.sensor.inverse_depth_offset);
  EXPECT_EQ(read.sensor.depth_pattern.nodes, config.sensor.depth_pattern.nodes);
  // A matrix halfway between two quaternions.
  EXPECT_LT((read.imu->T_BC.Matrix() - config.imu->T_BC.Matrix()).norm(), 1e-15);
  EXPECT_EQ(read.imu->noise.gyroscope_walk, config.imu->noise.gyroscope_walk);
  EXPECT_EQ(read.imu->time_offset, config.imu->time_offset);
  EXPECT_EQ(read.imu->accelerometer_range, config.imu->accelerometer_range);
  EXPECT_TRUE(std::isinf(read.imu->gyroscope_range)) << "nobody said";
  config.imu.reset();
  WriteConfig(path, config);
  EXPECT_FALSE(ReadSensor(path).imu.has_value());
}

}  // namespace
}  // namespace highwall::apps::config_test
