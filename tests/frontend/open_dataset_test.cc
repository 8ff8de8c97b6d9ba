#include <highwall/frontend/input/open_dataset.h>

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/euroc_dataset.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "support/generated_tum.h"
#include "support/message_of.h"

namespace highwall::open_dataset_test {
namespace {

using testing::ExpectError;
using testing::TemporaryDirectory;
using testing::WriteText;
using testing::WriteTum;

std::string FormatOf(const std::filesystem::path& folder) {
  const DatasetReader* const reader = FindDatasetReader(folder);
  return reader == nullptr ? "" : std::string(reader->format);
}

TEST(OpenDataset, RecognizesAFormatByItsFiles) {
  const TemporaryDirectory folder;
  EXPECT_EQ(FormatOf(folder.path()), "");
  for (const char* list : {"rgb.txt", "depth.txt", "associations.txt"}) {
    std::filesystem::create_directories(folder / list / "tum");
    WriteText(folder / list / "tum" / list, "");
    EXPECT_EQ(FormatOf(folder / list / "tum"), "TUM RGB-D") << list;
  }
  std::filesystem::create_directories(folder / "mav0" / "cam0");
  WriteText(folder / "mav0" / "cam0" / "sensor.yaml", "");
  EXPECT_EQ(FormatOf(folder.path()), "EuRoC");
  EXPECT_EQ(FormatOf(folder / "mav0"), "EuRoC");
}

TEST(OpenDataset, ConvertsDepthByTheWholeSensor) {
  const TemporaryDirectory folder;
  WriteTum(folder.path(), {.raw_depth = 2000});
  RgbdSensor sensor{
      .camera = {.width = 64, .height = 48, .fx = 50, .fy = 50, .cx = 31.5, .cy = 23.5},
      .depth_factor = 1000.0,
      .inverse_depth_offset = 0.02};
  sensor.depth_pattern.nodes.setConstant(0.03);
  const auto dataset = OpenDataset(folder.path(), sensor);
  EXPECT_NE(dynamic_cast<const TumDataset*>(dataset.get()), nullptr);
  EXPECT_EQ(dataset->calibration(), nullptr);
  const auto image = dataset->Load(0);
  ASSERT_TRUE(image);
  EXPECT_NEAR(image->depth.at<float>(5, 6), 1.0 / (0.5 - 0.02 - 0.03), 1e-6);
}

TEST(OpenDataset, WithoutASensorImagesMayHaveAnySize) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  EXPECT_EQ(OpenDataset(folder.path())->size(), 6u);
  ExpectError<IoError>("but the camera is set to 640 x 480",
                       [&] { OpenDataset(folder.path(), RgbdSensor()); });
}

TEST(OpenDataset, TakesTheDifferenceOfStamps) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  ExpectError<IoError>("no stamp of rgb.txt has one of depth.txt within 0.001 s", [&] {
    OpenDataset(folder.path(), std::nullopt, {.max_stamp_difference = 0.001});
  });
  ExpectError("DatasetOptions::max_stamp_difference",
              [&] { OpenDataset(folder.path(), std::nullopt, {.max_stamp_difference = 0.0}); });
}

TEST(OpenDataset, NamesTheFolderAndTheFilesThatItLookedFor) {
  const TemporaryDirectory folder;
  ExpectError<IoError>("nowhere: does not exist", [&] { OpenDataset(folder / "nowhere"); });
  ExpectError<IoError>(folder.path().string() + ": is empty", [&] { OpenDataset(folder.path()); });
  WriteText(folder / "notes.txt", "colour is in the other folder");
  ExpectError<IoError>("notes.txt: is not a directory", [&] { OpenDataset(folder / "notes.txt"); });
  const std::string message = testing::MessageOf<IoError>([&] { OpenDataset(folder.path()); });
  EXPECT_TRUE(message.starts_with(folder.path().string())) << message;
  for (const DatasetReader& reader : DatasetReaders()) {
    EXPECT_NE(message.find(reader.format), std::string::npos) << message;
    EXPECT_NE(message.find(reader.marks), std::string::npos) << message;
  }
}

// As in the settings files of ORB-SLAM2.
const std::string kWithoutSize =
    "%YAML:1.0\nCamera.fx: 50\nCamera.fy: 51\nCamera.cx: 31\nCamera.cy: 23\n";

TEST(ReadSensor, TakesTheSizeThatAFileDoesNotStateFromTheImagesOfTheRecording) {
  const TemporaryDirectory folder;
  const std::filesystem::path file = folder / "orb.yaml";
  WriteTum(folder / "tum");
  WriteText(file, kWithoutSize);
  const SensorCalibration read = ReadSensor(file, folder / "tum");
  EXPECT_EQ(read.sensor.camera.width, 64);
  EXPECT_EQ(read.sensor.camera.height, 48);
  EXPECT_EQ(read.sensor.camera.fy, 51.0);
  EXPECT_EQ(read.format, "a settings file of ORB-SLAM (for 64 x 48, the size of the images)");
  ExpectError<IoError>(file.string() + ":2: Camera.width and Camera.height are missing",
                       [&] { ReadSensor(file); });
  // What belongs to other images is noticed.
  WriteTum(folder / "small", {.width = 24, .height = 48});
  ExpectError<IoError>(file.string() + ":2: cx is 31 px, outside of the image, whose width is 24",
                       [&] { ReadSensor(file, folder / "small"); });
}

TEST(ReadSensor, TakesTheSizeThatAFileDoesNotStateFromACamera) {
  const TemporaryDirectory folder;
  const std::filesystem::path file = folder / "orb.yaml";
  WriteText(file, kWithoutSize);
  EXPECT_EQ(ReadSensor(file, cv::Size(64, 48)).sensor.camera.width, 64);
  WriteText(file, kWithoutSize + "Camera.width: 80\nCamera.height: 60\n");
  EXPECT_EQ(ReadSensor(file, cv::Size(64, 48)).sensor.camera.width, 80);
}

TEST(ReadSensor, OpensTheRecordingOnlyForASizeThatIsMissing) {
  const TemporaryDirectory folder;
  const std::filesystem::path file = folder / "orb.yaml", nowhere = folder / "nowhere";
  WriteText(file, kWithoutSize + "Camera.width: 64\nCamera.height: 48\n");
  EXPECT_EQ(ReadSensor(file, nowhere).format, "a settings file of ORB-SLAM");
  WriteText(file, kWithoutSize + "Camera.width: 64\n");
  ExpectError<IoError>(":2: Camera.width and Camera.height are missing",
                       [&] { ReadSensor(file, nowhere); });
  WriteText(file, kWithoutSize);
  ExpectError<IoError>("nowhere: does not exist", [&] { ReadSensor(file, nowhere); });
  WriteText(file,
            "camera: {width: 64, height: 48, fx: 50, fy: 50, cx: 31, cy: 23}\ndepth_factor: 1\n");
  EXPECT_EQ(ReadSensor(file, nowhere).sensor.camera.width, 64);
}

}  // namespace
}  // namespace highwall::open_dataset_test
