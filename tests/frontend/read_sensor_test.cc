#include <highwall/frontend/input/sensor.h>

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "support/message_of.h"
#include "support/temporary_directory.h"

// tests/apps/config_test.cc has every key and what programs do with the file.
namespace highwall::read_sensor_test {
namespace {

using testing::ExpectError;

class ReadSensorTest : public ::testing::Test {
 protected:
  SensorCalibration Read(const std::string& text) const {
    testing::WriteText(path(), text);
    return ReadSensor(path());
  }
  void ExpectRefused(const std::string& text, const std::string& message) const {
    ExpectError<IoError>(path().string() + message, [&] { Read(text); });
  }
  std::filesystem::path path() const { return folder_ / "calibration.yaml"; }

 private:
  const testing::TemporaryDirectory folder_;
};

const std::string kCamera =
    "camera: {width: 320, height: 240, fx: 260, fy: 261, cx: 159, cy: 120}\n";

TEST_F(ReadSensorTest, ReadsCameraDepthImuAndAntenna) {
  const SensorCalibration read = Read(kCamera +
                                      "depth_factor: 1000\n"
                                      "depth: {inverse_offset: -0.01}\n"
                                      "imu: {rate: 100, T_BC: [1, 0, 0, 0.5, 0, 1, 0, 0, "
                                      "0, 0, 1, 0, 0, 0, 0, 1]}\n"
                                      "gps: {antenna: [1, 2, 3]}\n");
  EXPECT_EQ(read.sensor.camera.height, 240);
  EXPECT_EQ(read.sensor.depth_factor, 1000.0);
  EXPECT_EQ(read.sensor.inverse_depth_offset, -0.01);
  ASSERT_TRUE(read.imu);
  EXPECT_EQ(read.imu->rate, 100.0);
  EXPECT_EQ(read.imu->T_BC.p(), Eigen::Vector3d(0.5, 0.0, 0.0));
  EXPECT_EQ(read.antenna_B, Eigen::Vector3d(1.0, 2.0, 3.0));
}

TEST_F(ReadSensorTest, NamesTheFileTheLineAndTheRemedy) {
  ExpectRefused(kCamera + "depth_facter: 1000\n",
                ":2: unknown key 'depth_facter'; did you mean 'depth_factor'?");
  ExpectRefused(kCamera + "depth_factor: -1\n", ":2: depth_factor must be positive");
  ExpectRefused(kCamera, ": key 'depth_factor' is missing");
  ExpectRefused("ppx: 500\nppy: 400\n",
                ": is the intrinsics of librealsense, which is not read; write");
  ExpectError<IoError>("calibratoin.yaml: is missing or cannot be read; did you mean '",
                       [&] { ReadSensor(path().parent_path() / "calibratoin.yaml"); });
}

TEST_F(ReadSensorTest, RefusesALensThatNoCameraHas) {
  const auto camera = [](const std::string& rest) {
    return "camera: {width: 640, height: 480, " + rest + "}\ndepth_factor: 1000\n";
  };
  ExpectRefused(camera("fx: 0.8, fy: 1.1, cx: 319, cy: 239"),
                ":1: camera: fx is 0.8 px, less than a tenth of the image's width (640): is it "
                "normalized? multiply it by the width");
  ExpectRefused(camera("fx: 525, fy: 525, cx: 960, cy: 239"),
                ":1: camera: cx is 960 px, outside of the image, whose width is 640: does it");
  ExpectRefused(camera("fx: 525, fy: 525, cx: 319, cy: -3"), ":1: camera: cy is -3 px, outside");
  ExpectRefused(camera("fx: 1050, fy: 525, cx: 319, cy: 239"),
                ":1: camera: fx is 1050 px and fy 525 px: pixels are about square");
  // Wide angle, a portrait image, and one whose sides were scaled from 16:9 to 4:3.
  EXPECT_NO_THROW(Read(camera("fx: 200, fy: 200, cx: 319, cy: 239")));
  EXPECT_NO_THROW(Read(camera("fx: 460, fy: 613, cx: 319, cy: 239")));
  EXPECT_NO_THROW(
      Read("camera: {width: 480, height: 640, fx: 525, fy: 525, cx: 239, cy: 319}\n"
           "depth_factor: 1000\n"));
}

}  // namespace
}  // namespace highwall::read_sensor_test
