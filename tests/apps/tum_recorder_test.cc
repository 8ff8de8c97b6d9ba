#include "cameras/tum_recorder.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/input/live_camera.h>
#include <highwall/frontend/input/open_dataset.h>

#include "support/message_of.h"
#include "support/temporary_directory.h"

namespace highwall::tum_recorder_test {
namespace {

namespace fs = std::filesystem;
using apps::RecordingCounts;
using apps::TumRecorder;

constexpr Stamp kStart = 1'700'000'000'123'456'789;
constexpr Stamp kInterval = 33'333'333;  // [ns]

SensorCalibration Calibration() {
  SensorCalibration calibration;
  calibration.sensor.camera = {
      .width = 64, .height = 48, .fx = 60.0, .fy = 60.0, .cx = 31.5, .cy = 23.5};
  calibration.sensor.depth_factor = 1000.0;
  return calibration;
}

// Random stored values of all sizes.
cv::Mat Stored(int number) {
  cv::Mat stored(48, 64, CV_16UC1);
  cv::RNG(static_cast<std::uint64_t>(number) + 7).fill(stored, cv::RNG::UNIFORM, 0, 65536);
  return stored;
}

RgbdImage Image(int number, const RgbdSensor& sensor) {
  RgbdImage image{.stamp = kStart + number * kInterval, .bgr = {}, .depth = {}};
  image.bgr.create(48, 64, CV_8UC3);
  cv::RNG(static_cast<std::uint64_t>(number) + 1).fill(image.bgr, cv::RNG::UNIFORM, 0, 256);
  image.depth = MetricDepth(Stored(number), sensor.depth_factor, sensor.inverse_depth_offset,
                            sensor.depth_pattern);
  if (number % 2 == 1) image.depth_stamp = image.stamp + 4'000'000;
  return image;
}

bool IsEqual(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

TEST(TumRecorder, ItsRecordingGivesTheSameImagesPixelByPixel) {
  SensorCalibration calibration = Calibration();
  for (const bool is_corrected : {false, true}) {
    if (is_corrected) {
      calibration.sensor.inverse_depth_offset = -0.01;
      calibration.sensor.depth_pattern.nodes.setLinSpaced(-0.02, 0.03);
    }
    const testing::TemporaryDirectory folder(is_corrected ? "corrected" : "plain");
    TumRecorder recorder(folder / "recording", calibration);
    for (int i = 0; i < 20; ++i) {
      const Stamp stamp = kStart + i * kInterval;
      const std::vector<ImuSample> readings = {{stamp, {0.1 * i, -1e-3, 0}, {0, 1.5, 9.8}},
                                               {stamp + 5'000'000, {1, 2, 3}, {4, 5, 6}}};
      recorder.Add(Image(i, calibration.sensor), readings);
    }
    const RecordingCounts counts = recorder.Finish();
    EXPECT_EQ(counts.images, 20U);
    EXPECT_EQ(counts.readings, 40U);
    EXPECT_EQ(counts.missed, 0U);

    const SensorCalibration read = ReadSensor(folder / "recording/calibration.yaml");
    EXPECT_EQ(read.sensor.depth_factor, 1000.0);
    const auto images = OpenDataset(folder / "recording", read.sensor);
    ASSERT_EQ(images->size(), 20U);
    for (std::size_t i = 0; i < images->size(); ++i) {
      const RgbdImage expected = Image(static_cast<int>(i), calibration.sensor);
      const auto image = images->Load(i);
      ASSERT_TRUE(image);
      EXPECT_EQ(image->stamp, expected.stamp);
      EXPECT_EQ(image->depth_stamp.value_or(image->stamp),
                expected.depth_stamp.value_or(expected.stamp));
      EXPECT_TRUE(IsEqual(image->bgr, expected.bgr)) << i;
      EXPECT_TRUE(IsEqual(image->depth, expected.depth)) << i;
    }
    const ImuRecording imu = ReadImu(images->imu_file().value(), {kStart, kStart + 20 * kInterval});
    ASSERT_EQ(imu.samples.size(), 40U);
    EXPECT_EQ(imu.samples[38].stamp, kStart + 19 * kInterval);
    EXPECT_EQ(imu.samples[38].gyroscope, Eigen::Vector3d(0.1 * 19, -1e-3, 0));
    EXPECT_EQ(imu.samples[39].accelerometer, Eigen::Vector3d(4, 5, 6));
  }
}

TEST(TumRecorder, AddNeverWaitsAndWhatIsNotRecordedIsCounted) {
  const testing::TemporaryDirectory folder;
  const SensorCalibration calibration = Calibration();
  TumRecorder recorder(folder / "recording", calibration);
  RgbdImage image = Image(0, calibration.sensor);
  const std::size_t added = 40 * TumRecorder::kMostWaiting;
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < added; ++i) {
    image.stamp += kInterval;
    recorder.Add(image, {});
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
  const RecordingCounts counts = recorder.Finish();
  EXPECT_GE(counts.images, TumRecorder::kMostWaiting);
  EXPECT_GT(counts.missed, 0U);
  EXPECT_EQ(counts.images + counts.missed, added);
  EXPECT_EQ(OpenDataset(folder / "recording")->size(), counts.images);
}

// As many images as the queue of the recorder holds, at once.
class Burst final : public ImageSource {
 public:
  std::optional<RgbdImage> Next() override {
    if (given_ == TumRecorder::kMostWaiting) return std::nullopt;
    return Image(static_cast<int>(given_++), calibration_.sensor);
  }
  void Stop() override {}
  const SensorCalibration* calibration() const override { return &calibration_; }

 private:
  const SensorCalibration calibration_ = Calibration();
  std::size_t given_ = 0;
};

TEST(TumRecorder, ImagesThatTrackingDropsAreRecordedAllTheSame) {
  const testing::TemporaryDirectory folder;
  Burst device;
  TumRecorder recorder(folder / "recording", *device.calibration());
  LiveCamera camera(device, {.on_image = [&](const RgbdImage& image, auto readings) {
                      recorder.Add(image, readings);
                    }});
  while (camera.Next()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_GT(camera.dropped(), 0U);
  EXPECT_EQ(recorder.Finish().images, TumRecorder::kMostWaiting);
  EXPECT_EQ(OpenDataset(folder / "recording")->size(), TumRecorder::kMostWaiting);
}

// The process that records is killed at any moment: what a list names can be read, and every line
// of it is whole.
TEST(TumRecorder, ARecordingThatIsKilledIsValid) {
  for (const int wait : {30, 70, 130}) {  // [ms]
    const testing::TemporaryDirectory folder(std::to_string(wait));
    const fs::path recording = folder / "recording";
    const pid_t child = ::fork();
    if (child == 0) {
      const SensorCalibration calibration = Calibration();
      TumRecorder recorder(recording, calibration);
      for (int i = 0;; ++i) {
        recorder.Add(Image(i, calibration.sensor), {});
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    }
    while (testing::ReadText(recording / "rgb.txt").find("png") == std::string::npos &&
           ::waitpid(child, nullptr, WNOHANG) == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(wait));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const auto images = OpenDataset(recording, Calibration().sensor);
    EXPECT_GT(images->size(), 0U);
    for (std::size_t i = 0; i < images->size(); ++i) EXPECT_TRUE(images->Load(i)) << i;
    for (const char* const list : {"rgb.txt", "depth.txt"}) {
      EXPECT_EQ(testing::ReadText(recording / list).back(), '\n') << list;
    }
  }
}

TEST(TumRecorder, AFolderWithContentIsRefused) {
  const testing::TemporaryDirectory folder;
  testing::WriteText(folder / "notes.txt", "mine");
  EXPECT_EQ(testing::MessageOf<IoError>([&] { TumRecorder(folder.path(), Calibration()); }),
            folder.path().string() + ": has content already: record to a new folder");
}

TEST(TumRecorder, AFolderThatVanishesEndsTheRecordingAlone) {
  const testing::TemporaryDirectory folder;
  const SensorCalibration calibration = Calibration();
  TumRecorder recorder(folder / "recording", calibration);
  fs::remove_all(folder / "recording");
  for (int i = 0; i < 5; ++i) recorder.Add(Image(i, calibration.sensor), {});
  const RecordingCounts counts = recorder.Finish();
  EXPECT_EQ(counts.images, 0U);
  EXPECT_EQ(counts.missed, 5U);
  EXPECT_NE(counts.failure.find("cannot be written"), std::string::npos) << counts.failure;
}

}  // namespace
}  // namespace highwall::tum_recorder_test
