// Cameras of OpenNI 2, by its file device.
#include "cameras/openni2_camera.h"

#include <cmath>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/sensor_profile.h>

#include "support/message_of.h"
#include "support/oni_file.h"
#include "support/temporary_directory.h"

namespace highwall::openni2_camera_test {
namespace {

constexpr int kWidth = 80, kHeight = 60, kFrames = 8;
constexpr std::uint64_t kInterval = 100'000;  // [us]

cv::Mat Rgb(int number) {
  cv::Mat rgb(kHeight, kWidth, CV_8UC3);
  cv::RNG(static_cast<std::uint64_t>(number) + 1).fill(rgb, cv::RNG::UNIFORM, 0, 256);
  return rgb;
}

cv::Mat Depth(int number) {
  cv::Mat depth(kHeight, kWidth, CV_16UC1);
  cv::RNG(static_cast<std::uint64_t>(number) + 9).fill(depth, cv::RNG::UNIFORM, 0, 9000);
  return depth;
}

testing::OniFile Recording() {
  testing::OniFile file;
  for (int i = 0; i < kFrames; ++i) {
    file.frames.push_back(
        {5'000'000 + static_cast<std::uint64_t>(i) * kInterval, Rgb(i), Depth(i)});
  }
  return file;
}

class OpenNi2Camera : public ::testing::Test {
 protected:
  std::string File() const {
    testing::WriteOni(folder_ / "camera.oni", Recording());
    return folder_ / "camera.oni";
  }

  const testing::TemporaryDirectory folder_;
};

bool IsEqual(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

// On a busy machine a player leaves images out, which their stamps tell.
TEST_F(OpenNi2Camera, DeliversTheImagesOfARecordingWithTheirDistancesInTime) {
  const auto camera = apps::OpenOpenNi2Camera(File(), {});
  std::vector<RgbdImage> images;
  while (const auto image = camera->Next()) images.push_back(*image);
  ASSERT_GE(images.size(), 2U);
  EXPECT_LE(images.size(), static_cast<std::size_t>(kFrames));
  const Stamp start = images.back().stamp - (kFrames - 1) * static_cast<Stamp>(kInterval) * 1000;
  for (const RgbdImage& image : images) {
    const Stamp since = image.stamp - start;
    EXPECT_EQ(since % (static_cast<Stamp>(kInterval) * 1000), 0);
    const int number = static_cast<int>(since / 1000 / static_cast<Stamp>(kInterval));
    ASSERT_GE(number, 0);
    cv::Mat bgr;
    cv::cvtColor(Rgb(number), bgr, cv::COLOR_RGB2BGR);
    EXPECT_TRUE(IsEqual(image.bgr, bgr)) << number;
    EXPECT_TRUE(IsEqual(image.depth, MetricDepth(Depth(number), 1000.0))) << number;
  }
  EXPECT_FALSE(camera->Next()) << "it is played once";
}

TEST_F(OpenNi2Camera, StatesTheCameraOfItsFieldOfView) {
  const auto camera = apps::OpenOpenNi2Camera(File(), {});
  const RgbdSensor& sensor = camera->calibration()->sensor;
  EXPECT_EQ(sensor.camera.width, kWidth);
  EXPECT_NEAR(sensor.camera.fx, 40.0 / std::tan(0.5), 1e-4);  // fields of view are floats
  EXPECT_NEAR(sensor.camera.fy, 30.0 / std::tan(0.4), 1e-4);
  EXPECT_EQ(sensor.camera.cx, 39.5);
  EXPECT_EQ(sensor.depth_factor, 1000.0);
}

TEST_F(OpenNi2Camera, ACalibrationReplacesTheStatedCameraButNotTheUnitOfDepth) {
  SensorCalibration given{.sensor = *SensorPreset("tum1")};
  given.sensor.camera = {
      .width = kWidth, .height = kHeight, .fx = 70.0, .fy = 71.0, .cx = 40.0, .cy = 30.0};
  given.sensor.inverse_depth_offset = -0.01;
  const auto camera = apps::OpenOpenNi2Camera(File(), [&](const cv::Size&) { return given; });
  EXPECT_EQ(camera->calibration()->sensor.camera.fx, 70.0);
  EXPECT_EQ(camera->calibration()->sensor.depth_factor, 1000.0);
  const auto image = camera->Next();
  ASSERT_TRUE(image);
  const auto is_of = [&](int number) {
    return IsEqual(image->depth, MetricDepth(Depth(number), 1000.0, -0.01));
  };
  EXPECT_TRUE(is_of(0) || is_of(1) || is_of(2) || is_of(3));
  given.sensor.camera.width = 100;
  EXPECT_NE(testing::MessageOf<IoError>([&] {
              apps::OpenOpenNi2Camera(File(), [&](const cv::Size&) { return given; });
            }).find("has colour images of 80 x 60 pixels, and the camera 100 x 60"),
            std::string::npos);
}

TEST_F(OpenNi2Camera, ACalibrationLearnsTheSizeOfTheImages) {
  cv::Size size;
  const auto camera = apps::OpenOpenNi2Camera(File(), [&](const cv::Size& usual) {
    size = usual;
    const PinholeCamera lens{
        .width = usual.width, .height = usual.height, .fx = 70, .fy = 71, .cx = 40, .cy = 30};
    return SensorCalibration{.sensor = FindSensorProfile("kinect1")->SensorFor(lens)};
  });
  EXPECT_EQ(size, cv::Size(kWidth, kHeight));
  EXPECT_EQ(camera->calibration()->sensor.camera.width, kWidth);
}

TEST_F(OpenNi2Camera, EndsWhenItIsStoppedFromAnotherThread) {
  testing::OniFile file = Recording();
  for (std::size_t i = 2; i < file.frames.size(); ++i) file.frames[i].microseconds += 60'000'000;
  testing::WriteOni(folder_ / "pause.oni", file);
  const auto start = std::chrono::steady_clock::now();
  const auto camera = apps::OpenOpenNi2Camera(folder_ / "pause.oni", {});
  ASSERT_TRUE(camera->Next());
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    camera->Stop();
  });
  while (camera->Next()) {
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

// The player of OpenNI goes through the streams without a lock, at full speed after the end.
TEST_F(OpenNi2Camera, ManyRecordingsMayBePlayedOneAfterTheOther) {
  testing::OniFile file = Recording();
  file.frames.resize(3);
  for (std::size_t i = 0; i < 3; ++i) file.frames[i].microseconds = 1'000'000 + i * 5000;
  testing::WriteOni(folder_ / "short.oni", file);
  for (int i = 0; i < 15; ++i) {
    const auto camera = apps::OpenOpenNi2Camera(folder_ / "short.oni", {});
    while (camera->Next()) {
    }
  }
}

TEST_F(OpenNi2Camera, WhatIsNoRecordingIsRefused) {
  testing::WriteText(folder_ / "text.oni", "this is no recording");
  for (const char* const name : {"text.oni", "missing.oni"}) {
    EXPECT_NE(testing::MessageOf<IoError>([&] {
                apps::OpenOpenNi2Camera(folder_ / name, {});
              }).find("is no recording of OpenNI 2 (.oni) that can be read"),
              std::string::npos)
        << name;
  }
}

TEST_F(OpenNi2Camera, ARecordingThatIsCutShortEnds) {
  const std::string text = testing::ReadText(File());
  testing::WriteText(folder_ / "cut.oni", text.substr(0, text.size() / 2));
  const auto camera = apps::OpenOpenNi2Camera(folder_ / "cut.oni", {});
  std::size_t images = 0;
  while (camera->Next()) ++images;
  EXPECT_GE(images, 1U);
  EXPECT_LT(images, static_cast<std::size_t>(kFrames));
}

}  // namespace
}  // namespace highwall::openni2_camera_test
