// Recordings whose images have numbers and no stamps: Open3D, 7-Scenes, and pairs of folders.
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/open_dataset.h>

#include "input/numbered_pairs_dataset.h"
#include "input/open3d_dataset.h"
#include "input/seven_scenes_dataset.h"
#include "support/message_of.h"
#include "support/temporary_directory.h"
#include "support/test_paths.h"

namespace highwall::numbered_datasets_test {
namespace {

namespace fs = std::filesystem;
using testing::MessageOf;
using testing::TemporaryDirectory;
using testing::WriteText;

const cv::Size kSize(64, 48);

cv::Mat Colour(int seed) {
  cv::Mat image(kSize, CV_8UC3);
  cv::RNG(static_cast<std::uint64_t>(seed) + 1).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

// [mm] 1 to 4 m; one pixel is full.
cv::Mat Depth(int seed) {
  cv::Mat image(kSize, CV_16UC1);
  cv::RNG(static_cast<std::uint64_t>(seed) + 1).fill(image, cv::RNG::UNIFORM, 1000, 4000);
  image.at<std::uint16_t>(0, 0) = UINT16_MAX;
  return image;
}

void WriteImage(const fs::path& path, const cv::Mat& image) {
  fs::create_directories(path.parent_path());
  ASSERT_TRUE(cv::imwrite(path.string(), image));
}

void ExpectFrame(const Dataset& dataset, std::size_t index, int seed) {
  const auto image = dataset.Load(index);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->stamp, dataset.stamp(index));
  EXPECT_EQ(cv::norm(image->bgr, Colour(seed), cv::NORM_INF), 0.0);
  const cv::Mat raw = Depth(seed);
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      const std::uint16_t stored = raw.at<std::uint16_t>(v, u);
      ASSERT_FLOAT_EQ(image->depth.at<float>(v, u), stored == UINT16_MAX ? 0.0F : 1e-3F * stored);
    }
  }
}

std::string SixDigits(int number) {
  const std::string digits = std::to_string(number);
  return std::string(6 - digits.size(), '0') + digits;
}

constexpr const char* kIntrinsic =
    "{\n\t\"width\" : 64,\n\t\"height\" : 48,\n\t\"intrinsic_matrix\" :\n\t[\n\t\t50.5,\n\t\t0,\n"
    "\t\t0,\n\t\t0,\n\t\t50,\n\t\t0,\n\t\t31,\n\t\t23,\n\t\t1\n\t]\n}\n";

// Five frames; the fourth has no depth.
void WriteOpen3d(const fs::path& folder) {
  for (int i = 0; i < 5; ++i) {
    WriteImage(folder / "color" / (SixDigits(i) + ".png"), Colour(i));
    if (i != 3) WriteImage(folder / "depth" / (SixDigits(i) + ".png"), Depth(i));
  }
  WriteText(folder / "camera_intrinsic.json", kIntrinsic);
}

TEST(Open3d, ReadsImagesPixelByPixelAndSpacesThemByTheRate) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder.path());
  const auto dataset = OpenDataset(folder.path());
  ASSERT_NE(dynamic_cast<const Open3dDataset*>(dataset.get()), nullptr);
  ASSERT_EQ(dataset->size(), 4U);
  EXPECT_EQ(dataset->stamp(0), 0);
  EXPECT_EQ(dataset->stamp(1), 33'333'333);
  EXPECT_EQ(dataset->stamp(3), 133'333'333);  // the gap stays
  EXPECT_EQ(dataset->stamps_without_depth(), std::vector<Stamp>{100'000'000});
  ASSERT_EQ(dataset->warnings().size(), 1U);
  EXPECT_EQ(dataset->warnings()[0],
            folder.path().string() +
                ": the recording has no stamps: 30 frames a second are assumed; state the rate "
                "with --fps");
  ExpectFrame(*dataset, 3, 4);
  EXPECT_EQ(OpenDataset(folder.path(), std::nullopt, {.frame_rate = 10.0})->stamp(3), 400'000'000);
}

TEST(Open3d, ReadsTheCameraColumnByColumn) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder.path());
  const Open3dDataset dataset(folder.path());
  ASSERT_NE(dataset.calibration(), nullptr);
  const RgbdSensor& sensor = dataset.calibration()->sensor;
  EXPECT_EQ(sensor.depth_factor, 1000.0);
  EXPECT_EQ(sensor.camera.fx, 50.5);
  EXPECT_EQ(sensor.camera.fy, 50.0);
  EXPECT_EQ(sensor.camera.cx, 31.0);
  EXPECT_EQ(sensor.camera.cy, 23.0);
}

TEST(Open3d, TakesTheSensorThatIsGivenInPlaceOfItsOwn) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder.path());
  const PinholeCamera camera{.width = 64, .height = 48, .fx = 50, .fy = 50, .cx = 32, .cy = 24};
  const Open3dDataset dataset(folder.path(), RgbdSensor{.camera = camera, .depth_factor = 2000.0});
  EXPECT_FLOAT_EQ(dataset.Load(0)->depth.at<float>(1, 1), 5e-4F * Depth(0).at<std::uint16_t>(1, 1));
  EXPECT_NE(MessageOf<IoError>([&] {
              const Open3dDataset other(folder.path(), RgbdSensor{.depth_factor = 1000.0});
              if (!other.Load(0)) throw IoError(folder.path(), other.problems()[0].what);
            }).find("gives a frame of 64 x 48, but the camera is set to 640 x 480"),
            std::string::npos);
}

TEST(Open3d, PosesOfTheLogAreTheReference) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder.path());
  WriteText(folder / "trajectory.log",
            "0 0 1\n1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n"
            "4 4 5\n0 -1 0 4\n1 0 0 5\n0 0 1 6\n0 0 0 1\n"
            "9 9 10\n1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n");
  const Open3dDataset dataset(folder.path());
  ASSERT_NE(dataset.groundtruth(), nullptr);
  ASSERT_EQ(dataset.groundtruth()->size(), 2U);
  EXPECT_EQ(dataset.groundtruth()->at(1).stamp, 133'333'333);
  EXPECT_TRUE(dataset.groundtruth()->at(1).pose.p().isApprox(Eigen::Vector3d(4, 5, 6)));
}

TEST(Open3d, ALogThatCannotBeReadIsNamedAndNotUsed) {
  for (const auto& [text, part] :
       {std::pair("0 0\n", ":1: must hold three whole numbers"),
        {"0 0 1\n1 0 0\n", ":2: must hold four numbers of a pose"},
        {"0 0 1\n1 0 0 0\n0 1 0 0\n", ":3: ends inside of a pose"},
        {"0 0 1\n1 0 0 x\n", ":2: 'x' is not a number"},
        {"0 0 1\n1 0 0 0\n0 1 0 0\n0 0 2 0\n0 0 0 1\n", ":5: ends a matrix that is no rotation"},
        {"", ": holds no pose"}}) {
    const TemporaryDirectory folder;
    WriteOpen3d(folder.path());
    WriteText(folder / "trajectory.log", text);
    const Open3dDataset dataset(folder.path());
    EXPECT_EQ(dataset.groundtruth(), nullptr);
    ASSERT_EQ(dataset.warnings().size(), 2U);
    EXPECT_NE(dataset.warnings()[1].find("trajectory.log" + std::string(part)), std::string::npos)
        << dataset.warnings()[1];
    EXPECT_TRUE(dataset.warnings()[1].ends_with("; the reference poses are not used"));
  }
}

TEST(Open3d, NamesAnIntrinsicOfAnotherForm) {
  const auto message = [](const std::string& json) {
    const TemporaryDirectory folder;
    WriteOpen3d(folder.path());
    WriteText(folder / "camera_intrinsic.json", json);
    return MessageOf<IoError>([&] { Open3dDataset(folder.path()); });
  };
  EXPECT_NE(message("{\"width\": 64}").find("json: has no 'intrinsic_matrix'"), std::string::npos);
  const std::string matrix = "\"intrinsic_matrix\": [50,0,0,0,50,0,31,23,1]";
  EXPECT_NE(message("{" + matrix + "}").find("json: has no 'width'"), std::string::npos);
  EXPECT_NE(message("{" + matrix + ", \"width\": 64, \"height\": 64}")
                .find("json: is for images of 64 x 64, but the colour images are 64 x 48"),
            std::string::npos);
}

TEST(Open3d, DepthOfAnotherSizeIsRefused) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder.path());
  for (int i = 0; i < 5; ++i) {
    WriteImage(folder / "depth" / (SixDigits(i) + ".png"),
               cv::Mat(24, 32, CV_16UC1, cv::Scalar(1000)));
  }
  EXPECT_NE(MessageOf<IoError>([&] {
              Open3dDataset(folder.path());
            }).find("is 32 x 24, but its colour image is 64 x 48; depth must be registered"),
            std::string::npos);
}

TEST(Open3d, ARecordingWithoutAnyDepthIsRefused) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder.path());
  for (int i = 0; i < 5; ++i) {
    WriteImage(folder / "depth" / (SixDigits(i) + ".png"), cv::Mat::zeros(kSize, CV_16UC1));
  }
  const std::string what = MessageOf<IoError>([&] { Open3dDataset(folder.path()); });
  EXPECT_NE(what.find("none of its 5 frames can be used; the first: "), std::string::npos) << what;
  EXPECT_TRUE(what.ends_with("000000.png: holds no depth: all zero")) << what;
}

// Frames 150 to 153.
void WriteSevenScenes(const fs::path& folder) {
  for (int i = 150; i < 154; ++i) {
    const std::string name = "frame-" + SixDigits(i);
    WriteImage(folder / (name + ".color.png"), Colour(i));
    WriteImage(folder / (name + ".depth.png"), Depth(i));
    WriteText(folder / (name + ".pose.txt"),
              "0\t-1\t0\t" + std::to_string(i) + "\n1\t0\t0\t2\n0\t0\t1\t3\n0\t0\t0\t1\n");
  }
  WriteText(folder / "camera-intrinsics.txt", "50 0 31\n 0 50 23\n 0 0 1\n");
}

TEST(SevenScenes, ReadsImagesPosesAndTheCamera) {
  const TemporaryDirectory folder;
  WriteSevenScenes(folder.path());
  const auto dataset = OpenDataset(folder.path());
  ASSERT_NE(dynamic_cast<const SevenScenesDataset*>(dataset.get()), nullptr);
  ASSERT_EQ(dataset->size(), 4U);
  ExpectFrame(*dataset, 2, 152);
  ASSERT_NE(dataset->groundtruth(), nullptr);
  ASSERT_EQ(dataset->groundtruth()->size(), 4U);
  EXPECT_EQ(dataset->groundtruth()->at(2).stamp, dataset->stamp(2));
  EXPECT_TRUE(dataset->groundtruth()->at(2).pose.p().isApprox(Eigen::Vector3d(152, 2, 3)));
  EXPECT_EQ(dataset->calibration()->sensor.camera.cx, 31.0);
  EXPECT_EQ(dataset->warnings().size(), 1U);  // no stamps
}

TEST(SevenScenes, FindsTheCameraInTheFolderAboveOrHasNone) {
  const TemporaryDirectory folder;
  WriteSevenScenes(folder / "seq-01");
  fs::rename(folder / "seq-01" / "camera-intrinsics.txt", folder / "camera-intrinsics.txt");
  EXPECT_NE(SevenScenesDataset(folder / "seq-01").calibration(), nullptr);
  fs::remove(folder / "camera-intrinsics.txt");
  EXPECT_EQ(SevenScenesDataset(folder / "seq-01").calibration(), nullptr);
}

TEST(SevenScenes, PosesThatAreNoneAreLeftOutWithOneWarning) {
  const TemporaryDirectory folder;
  WriteSevenScenes(folder.path());
  WriteText(folder / "frame-000151.pose.txt", "nan nan nan nan\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  WriteText(folder / "frame-000152.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1\n");
  fs::remove(folder / "frame-000153.pose.txt");
  const SevenScenesDataset dataset(folder.path());
  EXPECT_EQ(dataset.groundtruth()->size(), 1U);
  ASSERT_EQ(dataset.warnings().size(), 2U);
  EXPECT_NE(dataset.warnings()[1].find("frame-000151.pose.txt: is no rotation and translation; 2 "
                                       "of 4 reference poses are not used"),
            std::string::npos)
      << dataset.warnings()[1];
}

TEST(SevenScenes, AMissingImageIsNoFrameAndABrokenOneAProblem) {
  const TemporaryDirectory folder;
  WriteSevenScenes(folder.path());
  WriteText(folder / "frame-000151.depth.png", "no image");
  fs::remove(folder / "frame-000152.depth.png");
  const SevenScenesDataset dataset(folder.path());
  ASSERT_EQ(dataset.size(), 3U);
  EXPECT_FALSE(dataset.Load(1));
  EXPECT_NE(dataset.problems().at(0).what.find("frame-000151.depth.png: "), std::string::npos);
}

TEST(NumberedPairs, ReadsTheUsualFolders) {
  for (const auto& [colour, depth, suffix] : {std::tuple("color", "depth", ".pgm"),
                                              {"rgb_png", "depth_png", ".png"},
                                              {"rgb", "depth", ".png"}}) {
    SCOPED_TRACE(colour);
    const TemporaryDirectory folder;
    for (int i = 1; i <= 12; ++i) {
      WriteImage(folder / colour / (std::to_string(i) + ".png"), Colour(i));
      WriteImage(folder / depth / (std::to_string(i) + suffix), Depth(i));
    }
    const auto dataset =
        OpenDataset(folder.path(), RgbdSensor{.depth_factor = 1000.0}, {.any_size = true});
    ASSERT_NE(dynamic_cast<const NumberedPairsDataset*>(dataset.get()), nullptr);
    ASSERT_EQ(dataset->size(), 12U);
    EXPECT_EQ(dataset->calibration(), nullptr);
    ExpectFrame(*dataset, 9, 10);  // by number, not by name
  }
}

TEST(NumberedPairs, NumbersThatAreTimesAreTheStamps) {
  const TemporaryDirectory folder;
  for (const char* const name : {"1520531124150444163", "1520531124183788163"}) {
    WriteImage(folder / "rgb" / (std::string(name) + ".png"), Colour(1));
    WriteImage(folder / "depth" / (std::string(name) + ".png"), Depth(1));
  }
  const NumberedPairsDataset dataset(folder.path(), RgbdSensor{.depth_factor = 1000.0},
                                     {.any_size = true});
  EXPECT_EQ(dataset.stamp(0), 1520531124150444163);
  EXPECT_EQ(dataset.stamp(1), 1520531124183788163);
  ASSERT_EQ(dataset.warnings().size(), 1U);
  EXPECT_NE(dataset.warnings()[0].find("are taken for their stamps, in nanoseconds"),
            std::string::npos);
}

TEST(NumberedPairs, TheDepthFactorOfTheBenchmarkIsNamedWhereItCannotBe) {
  const TemporaryDirectory folder;
  for (int i = 0; i < 2; ++i) {
    const std::string name = std::to_string(i) + ".png";
    WriteImage(folder / "rgb" / name, Colour(i));
    WriteImage(folder / "depth" / name, cv::Mat(kSize, CV_16UC1, cv::Scalar(400)));
  }
  const NumberedPairsDataset dataset(folder.path());
  ASSERT_EQ(dataset.warnings().size(), 2U);
  EXPECT_NE(dataset.warnings()[1].find("the factor is likely 1000"), std::string::npos)
      << dataset.warnings()[1];
}

TEST(NumberedPairs, NumbersThatDoNotMeetAreNamed) {
  const TemporaryDirectory folder;
  WriteImage(folder / "rgb/1.png", Colour(1));
  WriteImage(folder / "depth/2.png", Depth(1));
  EXPECT_EQ(
      MessageOf<IoError>([&] { OpenDataset(folder.path()); }),
      folder.path().string() + ": holds no colour image with a depth image of the same number");
}

TEST(NumberedFormats, AFolderWithListsStaysOfTum) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder.path());
  WriteText(folder / "associations.txt", "0 color/000000.png 0 depth/000000.png\n");
  EXPECT_EQ(FindDatasetReader(folder.path())->format, "TUM RGB-D");
}

TEST(NumberedFormats, TheRateMustBePositive) {
  const TemporaryDirectory folder;
  WriteOpen3d(folder.path());
  testing::ExpectError("DatasetOptions::frame_rate",
                       [&] { OpenDataset(folder.path(), std::nullopt, {.frame_rate = 0.0}); });
}

// The images of an excerpt, pixel by pixel.
void ExpectImages(const Dataset& dataset, std::size_t index, const fs::path& colour,
                  const fs::path& depth) {
  const auto image = dataset.Load(index);
  ASSERT_TRUE(image);
  const cv::Mat expected = cv::imread(colour.string());
  EXPECT_EQ(cv::norm(image->bgr, expected, cv::NORM_INF), 0.0);
  const cv::Mat raw = cv::imread(depth.string(), cv::IMREAD_UNCHANGED);
  for (int v = 0; v < raw.rows; ++v) {
    for (int u = 0; u < raw.cols; ++u) {
      ASSERT_FLOAT_EQ(image->depth.at<float>(v, u), 1e-3F * raw.at<std::uint16_t>(v, u));
    }
  }
}

TEST(Open3d, ReadsARealExcerpt) {
  const fs::path folder = fs::path(testing::kSharedData) / "layouts/open3d_recorder";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << ": no shared/data here";
  const Open3dDataset dataset(folder);
  ASSERT_EQ(dataset.size(), 12U);
  EXPECT_EQ(dataset.calibration()->sensor.camera.fx, 380.71978759765625);
  EXPECT_EQ(dataset.calibration()->sensor.camera.cy, 241.4718475341797);
  ExpectImages(dataset, 7, folder / "color/000007.jpg", folder / "depth/000007.png");
}

TEST(SevenScenes, ReadsARealExcerpt) {
  const fs::path folder = fs::path(testing::kSharedData) / "layouts/tsdf_fusion";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << ": no shared/data here";
  const SevenScenesDataset dataset(folder);
  ASSERT_EQ(dataset.size(), 12U);
  EXPECT_EQ(dataset.calibration()->sensor.camera.fx, 585.0);
  ASSERT_EQ(dataset.groundtruth()->size(), 12U);
  EXPECT_NEAR(dataset.groundtruth()->at(0).pose.p().x(), -0.91287065, 1e-12);
  ExpectImages(dataset, 3, folder / "frame-000153.color.jpg", folder / "frame-000153.depth.png");
}

}  // namespace
}  // namespace highwall::numbered_datasets_test
