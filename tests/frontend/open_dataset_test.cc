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

}  // namespace
}  // namespace highwall::open_dataset_test
