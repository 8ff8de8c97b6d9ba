#include "input/jpeg_extent.h"

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include <highwall/frontend/input/image_io.h>

#include "support/temporary_directory.h"

namespace highwall::jpeg_extent_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Picture {
  std::string name;
  Bytes bytes;
};

Bytes Encoded(int type, int width, int height, const std::vector<int>& parameters) {
  cv::Mat image(height, width, type);
  cv::RNG random(7);
  random.fill(image, cv::RNG::UNIFORM, 0, 255);
  image.rowRange(height / 2, height).setTo(cv::Scalar::all(90));  // whose blocks are short
  Bytes bytes;
  EXPECT_TRUE(cv::imencode(".jpg", image, bytes, parameters));
  return bytes;
}

// The sizes include some that end within a block.
std::vector<Picture> SequentialPictures() {
  std::vector<Picture> pictures;
  for (const int width : {64, 61, 129}) {
    const std::string size = std::to_string(width);
    pictures.push_back({"colour " + size, Encoded(CV_8UC3, width, 47, {})});
    pictures.push_back({"grey " + size, Encoded(CV_8UC1, width, 49, {})});
    pictures.push_back(
        {"restarts " + size, Encoded(CV_8UC3, width, 40, {cv::IMWRITE_JPEG_RST_INTERVAL, 3})});
    pictures.push_back(
        {"own tables " + size, Encoded(CV_8UC3, width, 33, {cv::IMWRITE_JPEG_OPTIMIZE, 1})});
  }
  return pictures;
}

Picture Progressive() {
  return {"progressive", Encoded(CV_8UC3, 61, 47, {cv::IMWRITE_JPEG_PROGRESSIVE, 1})};
}

Bytes CutBy(Bytes bytes, std::size_t count) {
  bytes.resize(bytes.size() - count);
  return bytes;
}

TEST(JpegExtent, IgnoresBytesThatCamerasAppend) {
  std::vector<Picture> pictures = SequentialPictures();
  pictures.push_back(Progressive());
  for (const Picture& picture : pictures) {
    SCOPED_TRACE(picture.name);
    EXPECT_EQ(ExtentOfJpeg(picture.bytes), JpegExtent::kWhole);
    for (const std::size_t count : {1U, 64U, 5000U}) {
      Bytes longer = picture.bytes;
      longer.insert(longer.end(), count, std::uint8_t{'x'});
      EXPECT_EQ(ExtentOfJpeg(longer), JpegExtent::kWhole);
    }
    Bytes pair = picture.bytes;  // as phones with two lenses write them
    pair.insert(pair.end(), picture.bytes.begin(), picture.bytes.end() - 100);
    EXPECT_EQ(ExtentOfJpeg(pair), JpegExtent::kWhole);
  }
}

TEST(JpegExtent, APictureLacksNoMoreThanItsEndMarker) {
  std::vector<Picture> pictures = SequentialPictures();
  pictures.push_back(Progressive());
  for (const Picture& picture : pictures) {
    SCOPED_TRACE(picture.name);
    EXPECT_EQ(ExtentOfJpeg(CutBy(picture.bytes, 1)), JpegExtent::kNoEnd);
    EXPECT_EQ(ExtentOfJpeg(CutBy(picture.bytes, 2)), JpegExtent::kNoEnd);
  }
}

TEST(JpegExtent, OneByteOfThePictureThatIsMissingIsNoticed) {
  for (const Picture& picture : SequentialPictures()) {
    SCOPED_TRACE(picture.name);
    for (std::size_t count = 3; count + 3 < picture.bytes.size(); count += 1 + count / 20) {
      EXPECT_EQ(ExtentOfJpeg(CutBy(picture.bytes, count)), JpegExtent::kTruncated) << count;
    }
  }
  const Picture progressive = Progressive();
  EXPECT_EQ(ExtentOfJpeg(CutBy(progressive.bytes, progressive.bytes.size() / 2)),
            JpegExtent::kTruncated);
}

TEST(JpegExtent, APictureWithoutItsEndMarkerIsReadAsIfItWereThere) {
  std::vector<Picture> pictures = SequentialPictures();
  pictures.push_back(Progressive());
  const testing::TemporaryDirectory folder;
  const auto read = [&](const Bytes& bytes) {
    const auto path = folder.path() / "a.jpg";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return ReadColourImage(path);
  };
  ::testing::internal::CaptureStderr();
  for (const Picture& picture : pictures) {
    SCOPED_TRACE(picture.name);
    const cv::Mat whole = read(picture.bytes);
    for (const std::size_t count : {1U, 2U}) {
      const cv::Mat image = read(CutBy(picture.bytes, count));
      ASSERT_EQ(image.size(), whole.size());
      EXPECT_EQ(cv::norm(image, whole, cv::NORM_INF), 0.0);
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "") << "libjpeg complains there";
}

}  // namespace
}  // namespace highwall::jpeg_extent_test
