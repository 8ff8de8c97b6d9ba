#include "images/encode.h"

#include <cstdint>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace highwall::encode_test {
namespace {

cv::Mat RandomImage(int type) {
  cv::Mat image(23, 41, type);
  cv::RNG random(5);
  random.fill(image, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 60000 : 256);
  return image;
}

TEST(EncodePng, KeepsEveryValue) {
  for (const int type : {CV_8UC1, CV_16UC1, CV_8UC3, CV_8UC4}) {
    const cv::Mat image = RandomImage(type);
    const cv::Mat read = cv::imdecode(EncodePng(image), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(read.type(), type);
    EXPECT_EQ(cv::norm(read, image, cv::NORM_INF), 0.0) << type;
  }
}

TEST(EncodePng, CompressesAsMuchAsIsAskedFor) {
  cv::Mat image(64, 80, CV_8UC3, cv::Scalar(10, 20, 30));
  for (const int compression : {0, 1, 3, 12}) {
    const std::vector<std::uint8_t> file = EncodePng(image, compression);
    EXPECT_EQ(cv::norm(cv::imdecode(file, cv::IMREAD_UNCHANGED), image, cv::NORM_INF), 0.0);
    EXPECT_EQ(file.size() > image.total() * image.elemSize(), compression == 0) << compression;
  }
  EXPECT_THROW(EncodePng(image, 13), std::invalid_argument);
}

TEST(EncodePng, EncodesAPartOfAnImage) {
  const cv::Mat part = RandomImage(CV_8UC3)(cv::Rect(5, 4, 20, 11));
  const cv::Mat read = cv::imdecode(EncodePng(part), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(cv::norm(read, part, cv::NORM_INF), 0.0);
}

TEST(EncodeJpeg, KeepsASmoothImageAlmost) {
  cv::Mat image(64, 80, CV_8UC3);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) image.at<cv::Vec3b>(y, x) = cv::Vec3i(x, 2 * y, x + y);
  }
  const cv::Mat read = cv::imdecode(EncodeJpeg(image, 95), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(read.type(), CV_8UC3);
  // Quality 95 divides by at most 12; colours at half the resolution differ by their slope.
  EXPECT_LE(cv::norm(read, image, cv::NORM_INF), 8.0);
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  EXPECT_EQ(cv::imdecode(EncodeJpeg(grey, 95), cv::IMREAD_UNCHANGED).type(), CV_8UC1);
}

TEST(Encode, RefusesOtherTypes) {
  EXPECT_THROW(EncodePng(RandomImage(CV_16UC3)), std::invalid_argument);
  EXPECT_THROW(EncodePng(cv::Mat()), std::invalid_argument);
  EXPECT_THROW(EncodeJpeg(RandomImage(CV_16UC1), 90), std::invalid_argument);
}

}  // namespace
}  // namespace highwall::encode_test
