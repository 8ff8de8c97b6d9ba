// Images in messages of ROS: encodings, rows, orders of bytes, transports.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>

#include "input/ros_image.h"
#include "support/bag_messages.h"
#include "support/message_of.h"
#include "support/recorded_scene.h"

namespace highwall::ros_image_test {
namespace {

using testing::CompressedImageMessage;
using testing::ExpectError;
using testing::ImageMessage;
using testing::SceneColour;
using testing::SceneDepth;
using testing::Serialization;

constexpr Serialization kAll[] = {Serialization::kRos1, Serialization::kCdr,
                                  Serialization::kBigEndianCdr};

const std::filesystem::path kPath = "file.bag";

BagTopic Topic(Serialization how, const std::string& type = "sensor_msgs/Image",
               const std::string& name = "/image") {
  return {name, type, how == Serialization::kRos1 ? MessageEncoding::kRos1 : MessageEncoding::kCdr,
          1};
}

ByteSpan Span(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

cv::Mat Colour(const BagTopic& topic, const std::string& message) {
  return DecodeRosColour({kPath, "the message", topic, Span(message)});
}
cv::Mat Depth(const BagTopic& topic, const std::string& message) {
  return DecodeRosDepth({kPath, "the message", topic, Span(message)});
}

void ExpectEqual(const cv::Mat& a, const cv::Mat& b) {
  ASSERT_EQ(a.type(), b.type());
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0.0);
}

cv::Mat Converted(const cv::Mat& image, int code) {
  cv::Mat result;
  cv::cvtColor(image, result, code);
  return result;
}

std::string Encoded(const cv::Mat& image, const char* extension) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(extension, image, bytes);
  return {bytes.begin(), bytes.end()};
}

TEST(RosImage, ColourIsTheSameInEveryEncodingAndSerialization) {
  const cv::Mat bgr = SceneColour(1);
  for (const Serialization how : kAll) {
    const auto decode = [&](const cv::Mat& image, const char* encoding) {
      return Colour(Topic(how), ImageMessage(how, 5, "f", image, encoding, 3));
    };
    ExpectEqual(decode(bgr, "bgr8"), bgr);
    ExpectEqual(decode(bgr, "8UC3"), bgr);
    ExpectEqual(decode(Converted(bgr, cv::COLOR_BGR2RGB), "rgb8"), bgr);
    ExpectEqual(decode(Converted(bgr, cv::COLOR_BGR2RGBA), "rgba8"), bgr);
    ExpectEqual(decode(Converted(bgr, cv::COLOR_BGR2BGRA), "bgra8"), bgr);
    const cv::Mat grey = Converted(bgr, cv::COLOR_BGR2GRAY);
    ExpectEqual(decode(grey, "mono8"), Converted(grey, cv::COLOR_GRAY2BGR));
  }
}

TEST(RosImage, TheTwoOrdersOfYuvGiveTheSameColour) {
  cv::Mat uyvy(4, 6, CV_8UC2), yuyv(4, 6, CV_8UC2);
  cv::RNG(3).fill(uyvy, cv::RNG::UNIFORM, 30, 220);
  for (int v = 0; v < uyvy.rows; ++v) {
    for (int u = 0; u < uyvy.cols; ++u) {
      const cv::Vec2b pixel = uyvy.at<cv::Vec2b>(v, u);
      yuyv.at<cv::Vec2b>(v, u) = {pixel[1], pixel[0]};
    }
  }
  const BagTopic topic = Topic(Serialization::kRos1);
  const auto message = [&](const cv::Mat& image, const char* encoding) {
    return ImageMessage(Serialization::kRos1, 5, "f", image, encoding);
  };
  const cv::Mat bgr = Colour(topic, message(uyvy, "yuv422"));
  EXPECT_EQ(bgr.size(), uyvy.size());
  ExpectEqual(bgr, Colour(topic, message(yuyv, "yuv422_yuy2")));
  ExpectError<IoError>("is in yuv422; colour is read in",
                       [&] { Colour(topic, message(uyvy.colRange(0, 5).clone(), "yuv422")); });
}

TEST(RosImage, DepthIsTheSameInBothOrdersOfBytes) {
  const cv::Mat depth = SceneDepth(2);
  cv::Mat swapped = depth.clone();
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const std::uint16_t value = depth.at<std::uint16_t>(v, u);
      swapped.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(value << 8 | value >> 8);
    }
  }
  for (const Serialization how : kAll) {
    for (const char* encoding : {"16UC1", "mono16"}) {
      ExpectEqual(Depth(Topic(how), ImageMessage(how, 5, "f", depth, encoding, 2)), depth);
      ExpectEqual(Depth(Topic(how), ImageMessage(how, 5, "f", swapped, encoding, 0, true)), depth);
    }
  }
}

TEST(RosImage, WhatWasNotMeasuredInMetresIsZero) {
  cv::Mat metres(2, 3, CV_32FC1, cv::Scalar(1.25F));
  metres.at<float>(0, 1) = std::numeric_limits<float>::quiet_NaN();
  metres.at<float>(1, 0) = std::numeric_limits<float>::infinity();
  metres.at<float>(1, 2) = -1.0F;
  const cv::Mat depth =
      Depth(Topic(Serialization::kCdr), ImageMessage(Serialization::kCdr, 5, "f", metres, "32FC1"));
  const cv::Mat expected = (cv::Mat_<float>(2, 3) << 1.25F, 0.0F, 1.25F, 0.0F, 1.25F, 0.0F);
  ExpectEqual(depth, expected);
}

TEST(RosImage, CompressedImagesAreThoseOfTheirFiles) {
  const cv::Mat bgr = SceneColour(1), depth = SceneDepth(1);
  const BagTopic topic = Topic(Serialization::kCdr, "sensor_msgs/CompressedImage");
  const auto message = [&](const char* format, const std::string& file) {
    return CompressedImageMessage(Serialization::kCdr, 5, "f", format, file);
  };
  ExpectEqual(Colour(topic, message("bgr8; png compressed bgr8", Encoded(bgr, ".png"))), bgr);
  const std::string jpeg = Encoded(bgr, ".jpg");
  ExpectEqual(Colour(topic, message("jpeg", jpeg)),
              cv::imdecode(std::vector<std::uint8_t>(jpeg.begin(), jpeg.end()), cv::IMREAD_COLOR));
  ExpectEqual(Depth(topic, message("16UC1; png compressed", Encoded(depth, ".png"))), depth);
  const std::string header(12, '\0');
  ExpectEqual(Depth(topic, message("16UC1; compressedDepth", header + Encoded(depth, ".png"))),
              depth);
  ExpectError<IoError>("is compressed by RVL", [&] {
    Depth(topic, message("16UC1; compressedDepth rvl", header + "data"));
  });
  ExpectError<IoError>("file.bag: the message: ",
                       [&] { Colour(topic, message("jpeg", jpeg.substr(0, jpeg.size() / 2))); });
  ExpectError<IoError>("is empty", [&] { Colour(topic, message("jpeg", "")); });
}

// z = a / (value - b), the way the transport quantizes inverse depth.
TEST(RosImage, CompressedDepthInMetresIsThatOfItsInverse) {
  const cv::Mat stored = SceneDepth(1);
  const float a = 1100.0F, b = 20.0F;
  std::string header(12, '\0');
  std::memcpy(header.data() + 4, &a, sizeof(a));
  std::memcpy(header.data() + 8, &b, sizeof(b));
  const BagTopic topic = Topic(Serialization::kRos1, "sensor_msgs/CompressedImage");
  const cv::Mat depth =
      Depth(topic, CompressedImageMessage(Serialization::kRos1, 5, "f", "32FC1; compressedDepth",
                                          header + Encoded(stored, ".png")));
  ASSERT_EQ(depth.type(), CV_32FC1);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const std::uint16_t value = stored.at<std::uint16_t>(v, u);
      const float expected = value == 0 ? 0.0F : a / (static_cast<float>(value) - b);
      EXPECT_EQ(depth.at<float>(v, u), expected);
    }
  }
}

TEST(RosImage, ADescriptionNamesKindFrameAndSize) {
  const auto describe = [](const BagTopic& topic, const std::string& message) {
    return DescribeRosImage({kPath, "the message", topic, Span(message)});
  };
  for (const Serialization how : kAll) {
    const RosImageDescription image =
        describe(Topic(how), ImageMessage(how, 5, "/camera", SceneColour(1), "bgr8"));
    EXPECT_EQ(image.kind, RosImageKind::kColour);
    EXPECT_EQ(image.frame, "camera");
    EXPECT_EQ(image.width, 64);
    EXPECT_EQ(image.height, 48);
    const cv::Mat metres(2, 3, CV_32FC1, cv::Scalar(1.0F));
    EXPECT_TRUE(describe(Topic(how), ImageMessage(how, 5, "c", metres, "32FC1")).in_metres);
    EXPECT_EQ(describe(Topic(how), ImageMessage(how, 5, "c", metres, "bayer_rggb8")).kind,
              RosImageKind::kOther);
    const BagTopic compressed =
        Topic(how, "sensor_msgs/CompressedImage", "/depth/image/compressedDepth");
    EXPECT_EQ(describe(compressed, CompressedImageMessage(how, 5, "c", "", "x")).kind,
              RosImageKind::kDepth);
  }
}

TEST(RosImage, AMessageWithFewerBytesThanPixelsIsRefused) {
  for (const Serialization how : kAll) {
    const std::string message = ImageMessage(how, 5, "f", SceneColour(1), "bgr8");
    for (std::size_t size = 0; size < message.size(); size += 61) {
      ExpectError<IoError>("file.bag: the message ",
                           [&] { Colour(Topic(how), message.substr(0, size)); });
    }
    ExpectError<IoError>("is damaged: 64 x 48 pixels in rgba8 cannot have 9216 bytes", [&] {
      Colour(Topic(how), ImageMessage(how, 5, "f", SceneColour(1), "rgba8"));
    });
    ExpectError<IoError>("is in bayer_rggb8; colour is read in rgb8", [&] {
      Colour(Topic(how), ImageMessage(how, 5, "f", SceneColour(1), "bayer_rggb8"));
    });
    ExpectError<IoError>("is in bgr8; depth is read in 16UC1", [&] {
      Depth(Topic(how), ImageMessage(how, 5, "f", SceneColour(1), "bgr8"));
    });
  }
}

TEST(MessageReader, OtherSerializationsAreRefused) {
  const BagTopic protobuf{"/image", "sensor_msgs/Image", MessageEncoding::kOther, 1};
  ExpectError<IoError>("is neither in the serialization of ROS 1 nor in CDR",
                       [&] { Colour(protobuf, "message"); });
  ExpectError<IoError>("is in another representation of CDR",
                       [&] { Colour(Topic(Serialization::kCdr), std::string("\0\3\0\0abcd", 8)); });
}

}  // namespace
}  // namespace highwall::ros_image_test
