#include "input/record3d_dataset.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/depth_check.h>
#include <highwall/frontend/input/open_dataset.h>

#include "input/exr_depth.h"
#include "support/message_of.h"
#include "support/temporary_directory.h"
#include "support/test_paths.h"

namespace highwall::record3d_dataset_test {
namespace {

namespace fs = std::filesystem;
using testing::MessageOf;
using testing::TemporaryDirectory;
using testing::WriteText;

void WriteExr(const fs::path& path, cv::Mat depth, const char* channel = "R") {
  fs::create_directories(path.parent_path());
  Imf::Header header(depth.cols, depth.rows);
  header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
  Imf::OutputFile file(path.string().c_str(), header);
  Imf::FrameBuffer buffer;
  buffer.insert(channel, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(depth.data), sizeof(float),
                                    depth.step[0]));
  file.setFrameBuffer(buffer);
  file.writePixels(depth.rows);
}

cv::Mat Colour(int seed) {
  cv::Mat image(64, 48, CV_8UC3);
  cv::RNG(static_cast<std::uint64_t>(seed) + 1).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

// [m]
cv::Mat Depth(int seed) {
  cv::Mat image(16, 12, CV_32FC1);
  cv::RNG(static_cast<std::uint64_t>(seed) + 1).fill(image, cv::RNG::UNIFORM, 0.5, 4.0);
  image.at<float>(0, 0) = std::numeric_limits<float>::quiet_NaN();
  image.at<float>(0, 1) = std::numeric_limits<float>::infinity();
  image.at<float>(0, 2) = -1.0F;
  return image;
}

// The camera matrix stands column by column.
std::string Metadata(const std::string& more) {
  return R"({"dh":16,"dw":12,"w":48,"h":64,"fps":60,"K":[50,0,0,0,50,0,23.5,31.5,1])" + more + "}";
}

constexpr const char* kStamps = R"(,"frameTimestamps":[0,0.016668042000674177,0.0333,0.05])";
constexpr const char* kPoses =
    R"(,"poses":[[0,0,0,1,0,0,0],[0,0,0.6,0.8,1,2,3],[0,0,0,0,0,0,0],[0,0,0,1,4,5,6]])";

// Four frames; the third has no depth.
void WriteRecord3d(const fs::path& folder, const std::string& more) {
  fs::create_directories(folder / "rgb");
  for (int i = 0; i < 4; ++i) {
    cv::imwrite((folder / "rgb" / (std::to_string(i) + ".png")).string(), Colour(i));
    if (i != 2) WriteExr(folder / "depth" / (std::to_string(i) + ".exr"), Depth(i));
  }
  WriteText(folder / "metadata.json", Metadata(more));
}

TEST(Record3d, ReadsImagesAndMetresPixelByPixel) {
  const TemporaryDirectory folder;
  WriteRecord3d(folder.path(), std::string(kStamps) + kPoses);
  const auto dataset = OpenDataset(folder.path());
  ASSERT_NE(dynamic_cast<const Record3dDataset*>(dataset.get()), nullptr);
  ASSERT_EQ(dataset->size(), 3U);
  EXPECT_EQ(dataset->stamp(1), 16'668'042);
  EXPECT_EQ(dataset->stamps_without_depth(), std::vector<Stamp>{33'300'000});
  EXPECT_TRUE(dataset->warnings().empty());
  const PinholeCamera& camera = dataset->calibration()->sensor.camera;
  EXPECT_EQ(camera.width, 48);
  EXPECT_EQ(camera.height, 64);
  EXPECT_EQ(camera.cx, 23.5);
  EXPECT_EQ(camera.cy, 31.5);
  const auto image = dataset->Load(1);
  ASSERT_TRUE(image);
  EXPECT_EQ(cv::norm(image->bgr, Colour(1), cv::NORM_INF), 0.0);
  const cv::Mat metres = Depth(1);
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 48; ++u) {
      const bool hole = v < 4 && u < 12;
      ASSERT_NEAR(image->depth.at<float>(v, u), hole ? 0.0F : metres.at<float>(v / 4, u / 4), 1e-6);
    }
  }
}

TEST(Record3d, TurnsThePosesOfArkitForwardAndLeavesLostOnesOut) {
  const TemporaryDirectory folder;
  WriteRecord3d(folder.path(), std::string(kStamps) + kPoses);
  const Record3dDataset dataset(folder.path());
  ASSERT_NE(dataset.groundtruth(), nullptr);
  ASSERT_EQ(dataset.groundtruth()->size(), 3U);
  EXPECT_TRUE(dataset.groundtruth()->at(1).pose.p().isApprox(Eigen::Vector3d(1, 2, 3)));
  Eigen::Matrix3d first = Eigen::Vector3d(1, -1, -1).asDiagonal();
  EXPECT_TRUE(dataset.groundtruth()->at(0).pose.R().isApprox(first, 1e-12));
}

TEST(Record3d, UprightImagesAreReadFromRightToLeft) {
  const TemporaryDirectory folder;
  WriteRecord3d(folder.path(), "");
  EXPECT_EQ(Record3dDataset(folder.path()).calibration()->sensor.timing.direction,
            ReadoutDirection::kLeft);
}

TEST(Record3d, WithoutStampsTheStatedRateSpacesTheFrames) {
  const TemporaryDirectory folder;
  WriteRecord3d(folder.path(), "");
  const Record3dDataset dataset(folder.path());
  EXPECT_EQ(dataset.stamp(2), 50'000'000);
  EXPECT_EQ(dataset.groundtruth(), nullptr);
}

TEST(Record3d, ReadsTheIntrinsicsOfEachFrame) {
  const TemporaryDirectory folder;
  WriteRecord3d(folder.path(),
                R"(,"perFrameIntrinsicCoeffs":[[51,51,23,31],[52,52,23,31],[53,53,23,31]])");
  const Record3dDataset dataset(folder.path());
  EXPECT_EQ(dataset.calibration()->sensor.camera.fx, 52.0);
}

TEST(Record3d, NamesWhatIsMissingOrMalformed) {
  const auto expect = [](const std::string& json, const std::string& part) {
    const TemporaryDirectory folder;
    WriteRecord3d(folder.path(), "");
    WriteText(folder / "metadata.json", json);
    const std::string what = MessageOf<IoError>([&] { Record3dDataset(folder.path()); });
    EXPECT_NE(what.find("metadata.json" + part), std::string::npos) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
  };
  expect("{\"w\": 48", ":1: is not JSON: ");
  expect("{}", ": has no 'K'");
  expect(R"({"K":[50,0,0,0,50,0,23.5,31.5,1],"w":48.5,"h":64})", ":1: 'w' must be a whole number");
  expect(R"({"K":[50,0,0,0,50,0,23.5,31.5,1],"w":0,"h":64})", ": w and h must be positive");
  expect(R"({"K":[.nan,0,0,0,50,0,23.5,31.5,1],"w":48,"h":64})",
         ":1: 'K' must be a list of 9 finite numbers");
  expect(Metadata(R"(,"poses":[[1,2,3]])"),
         ":1: each element of 'poses' must be a list of 7 finite numbers");
  expect(Metadata(std::string(kStamps) + R"(,"poses":[[0,0,0,1,0,0,0]])"),
         ": has 1 poses, but 4 frameTimestamps");
  expect(Metadata(R"(,"frameTimestamps":[0,"x"])"),
         ":1: 'frameTimestamps' must be a list of times in seconds");
}

TEST(Record3d, ImagesBeyondTheStampsAreNamed) {
  const TemporaryDirectory folder;
  WriteRecord3d(folder.path(), R"(,"frameTimestamps":[0,0.1])");
  const Record3dDataset dataset(folder.path());
  EXPECT_EQ(dataset.size(), 2U);
  ASSERT_EQ(dataset.warnings().size(), 1U);
  EXPECT_NE(dataset.warnings()[0].find("has no stamp for 2 images, which are not used"),
            std::string::npos);
}

TEST(Record3d, DepthInAnotherFormatIsNamed) {
  const TemporaryDirectory folder;
  WriteRecord3d(folder.path(), "");
  fs::remove_all(folder / "depth");
  fs::create_directories(folder / "depth");
  EXPECT_NE(MessageOf<IoError>([&] { Record3dDataset(folder.path()); }).find("holds no N.exr"),
            std::string::npos);
}

TEST(ReadExrDepth, ReadsTheChannelsThatDepthIsIn) {
  const TemporaryDirectory folder;
  for (const char* const channel : {"R", "Y", "Z"}) {
    WriteExr(folder / "a.exr", Depth(1), channel);
    EXPECT_EQ(ReadExrDepth(folder / "a.exr").at<float>(5, 6), Depth(1).at<float>(5, 6));
  }
  WriteExr(folder / "b.exr", Depth(1), "N");
  EXPECT_NE(MessageOf<IoError>([&] { ReadExrDepth(folder / "b.exr"); }).find("has no channel"),
            std::string::npos);
}

TEST(ReadExrDepth, NamesAFileThatIsMissingOrDamaged) {
  const TemporaryDirectory folder;
  EXPECT_NE(MessageOf<IoError>([&] { ReadExrDepth(folder / "a.exr"); }).find("a.exr: is missing"),
            std::string::npos);
  WriteText(folder / "a.exr", "no image");
  EXPECT_NE(MessageOf<IoError>([&] { ReadExrDepth(folder / "a.exr"); }).find("is no OpenEXR image"),
            std::string::npos);
  WriteExr(folder / "b.exr", Depth(1));
  fs::resize_file(folder / "b.exr", fs::file_size(folder / "b.exr") / 2);
  EXPECT_NE(MessageOf<IoError>([&] { ReadExrDepth(folder / "b.exr"); }).find("truncated"),
            std::string::npos);
}

TEST(Record3d, ReadsARealExcerpt) {
  const fs::path folder = fs::path(testing::kSharedData) / "layouts/record3d";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << ": no shared/data here";
  const Record3dDataset dataset(folder);
  ASSERT_EQ(dataset.size(), 12U);
  EXPECT_EQ(dataset.stamp(1), 16'668'042);
  EXPECT_EQ(dataset.calibration()->sensor.camera.width, 480);
  EXPECT_EQ(dataset.calibration()->sensor.camera.height, 640);
  ASSERT_EQ(dataset.groundtruth()->size(), 12U);
  // The edges of a few alike images agree elsewhere, but depth is registered by construction.
  EXPECT_TRUE(dataset.is_registered());
  EXPECT_TRUE(CheckDepth(dataset, dataset.calibration()->sensor).empty());
  const auto image = dataset.Load(10);
  ASSERT_TRUE(image);
  const cv::Mat colour = cv::imread((folder / "rgb/10.jpg").string());
  const cv::Mat metres = ReadExrDepth(folder / "depth/10.exr");
  for (int v = 0; v < 640; ++v) {
    for (int u = 0; u < 480; ++u) {
      const cv::Scalar mean = cv::mean(colour(cv::Rect(3 * u, 3 * v, 3, 3)));
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(image->bgr.at<cv::Vec3b>(v, u)[c], mean[c], 0.51);
      const int row = (2 * v + 1) * 256 / 1280, column = (2 * u + 1) * 192 / 960;
      ASSERT_NEAR(image->depth.at<float>(v, u), metres.at<float>(row, column), 1e-6);
    }
  }
}

}  // namespace
}  // namespace highwall::record3d_dataset_test
