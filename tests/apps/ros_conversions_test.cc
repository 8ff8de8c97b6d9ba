// Messages of ROS and types of Highwall.
#include "ros/conversions.h"

#include <sensor_msgs/image_encodings.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

namespace highwall::ros_conversions_test {
namespace {

namespace encodings = sensor_msgs::image_encodings;
using apps::ToRos;

sensor_msgs::Image Image(const std::string& encoding, std::vector<std::uint8_t> data,
                         std::uint32_t width, std::uint32_t step) {
  sensor_msgs::Image message;
  message.encoding = encoding;
  message.width = width;
  message.height = static_cast<std::uint32_t>(data.size()) / step;
  message.step = step;
  message.data = std::move(data);
  return message;
}

TEST(RosConversions, StampsKeepTheirNanoseconds) {
  const Stamp stamp = 1'700'000'000'123'456'789;
  EXPECT_EQ(apps::FromRos(ToRos(stamp)), stamp);
}

TEST(RosConversions, PosesReturn) {
  const Pose pose(Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {1.0, -2.0, 3.0});
  const Pose back = apps::FromRos(apps::ToRosTransform(pose));
  EXPECT_EQ(back.p(), pose.p());
  EXPECT_EQ(back.q().coeffs(), pose.q().coeffs());
}

TEST(RosConversions, CovariancesAreRowByRow) {
  apps::UncertainPose pose;
  for (int i = 0; i < 36; ++i) pose.covariance(i / 6, i % 6) = i;
  const geometry_msgs::PoseWithCovariance message = ToRos(pose);
  for (std::size_t i = 0; i < 36; ++i) EXPECT_EQ(message.covariance[i], static_cast<double>(i));
}

TEST(RosConversions, ColourIsBlueGreenRedWhateverTheOrderAndThePadding) {
  const cv::Vec3b expected(1, 2, 3);
  const auto first = [](const sensor_msgs::Image& message) {
    return apps::ColourOf(message).at<cv::Vec3b>(1, 0);
  };
  EXPECT_EQ(first(Image(encodings::BGR8, {9, 9, 9, 0, 1, 2, 3, 0}, 1, 4)), expected);
  EXPECT_EQ(first(Image(encodings::RGB8, {9, 9, 9, 3, 2, 1}, 1, 3)), expected);
  EXPECT_EQ(first(Image(encodings::RGBA8, {9, 9, 9, 9, 3, 2, 1, 255}, 1, 4)), expected);
  EXPECT_EQ(first(Image(encodings::BGRA8, {9, 9, 9, 9, 1, 2, 3, 255}, 1, 4)), expected);
  EXPECT_EQ(first(Image(encodings::MONO8, {9, 7}, 1, 1)), cv::Vec3b(7, 7, 7));
}

TEST(RosConversions, DepthIsAsItWasSent) {
  const cv::Mat whole = apps::DepthOf(Image(encodings::TYPE_16UC1, {0xe8, 0x03, 0, 0}, 2, 4));
  ASSERT_EQ(whole.type(), CV_16UC1);
  EXPECT_EQ(whole.at<std::uint16_t>(0, 0), 1000);
  const cv::Mat metres = apps::DepthOf(Image(encodings::TYPE_32FC1, {0, 0, 0x80, 0x3f}, 1, 4));
  ASSERT_EQ(metres.type(), CV_32FC1);
  EXPECT_EQ(metres.at<float>(0, 0), 1.0f);
}

TEST(RosConversions, ImagesThatCannotBeReadAreRefused) {
  EXPECT_THROW(apps::ColourOf(Image("bayer_rggb8", {1, 2, 3}, 3, 3)), InvalidArgument);
  EXPECT_THROW(apps::DepthOf(Image(encodings::BGR8, {1, 2, 3}, 1, 3)), InvalidArgument);
  sensor_msgs::Image shorter = Image(encodings::BGR8, {1, 2, 3, 4, 5, 6}, 1, 3);
  shorter.data.resize(5);
  EXPECT_THROW(apps::ColourOf(shorter), InvalidArgument);
  sensor_msgs::Image empty = Image(encodings::BGR8, {1, 2, 3}, 1, 3);
  empty.step = 0;
  EXPECT_THROW(apps::ColourOf(empty), InvalidArgument);
  sensor_msgs::Image other = Image(encodings::TYPE_16UC1, {1, 2}, 1, 2);
  other.is_bigendian = 1;
  EXPECT_THROW(apps::DepthOf(other), InvalidArgument);
}

sensor_msgs::CameraInfo Info(const std::string& model, const std::vector<double>& lens) {
  sensor_msgs::CameraInfo message;
  message.header.frame_id = "camera";
  message.width = 640;
  message.height = 480;
  message.K = {500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0};
  message.P = {510.0, 0.0, 321.0, 0.0, 0.0, 511.0, 241.0, 0.0, 0.0, 0.0, 1.0, 0.0};
  message.distortion_model = model;
  message.D = lens;
  return message;
}

TEST(RosConversions, CamerasHaveTheirLens) {
  const auto raw = apps::CameraOf(Info("plumb_bob", {0.1, -0.2, 0.001, 0.002, 0.05}), false);
  EXPECT_EQ(raw.frame, "camera");
  EXPECT_EQ(raw.camera.fy, 501.0);
  EXPECT_EQ(raw.camera.p2, 0.002);
  EXPECT_EQ(raw.camera.k3, 0.05);
  const auto fisheye = apps::CameraOf(Info("equidistant", {0.1, 0.2, 0.3, 0.4}), false);
  EXPECT_EQ(fisheye.camera.lens, LensModel::kEquidistant);
  EXPECT_EQ(fisheye.camera.k4, 0.4);
  const auto rectified = apps::CameraOf(Info("plumb_bob", {0.1, -0.2, 0.0, 0.0, 0.0}), true);
  EXPECT_EQ(rectified.camera.fx, 510.0);
  EXPECT_FALSE(rectified.camera.HasDistortion());
}

TEST(RosConversions, CamerasThatDoNotExistAreRefused) {
  EXPECT_THROW(apps::CameraOf(Info("inverse_brown", {0.1, 0.2, 0.3}), false), InvalidArgument);
  sensor_msgs::CameraInfo empty = Info("plumb_bob", {});
  empty.K.fill(0.0);
  EXPECT_THROW(apps::CameraOf(empty, false), InvalidArgument);
}

TEST(RosConversions, PointsKeepPlaceAndColour) {
  sensor_msgs::PointCloud2 message =
      ToRos(std::vector<apps::ColouredPoint>{{{1.0f, 2.0f, 3.0f}, 10, 20, 30}}, {});
  ASSERT_EQ(message.width, 1u);
  sensor_msgs::PointCloud2Iterator<float> p(message, "x");
  EXPECT_EQ(p[2], 3.0f);
  EXPECT_EQ(*sensor_msgs::PointCloud2Iterator<std::uint8_t>(message, "r"), 10);
  EXPECT_EQ(*sensor_msgs::PointCloud2Iterator<std::uint8_t>(message, "b"), 30);
}

TEST(RosConversions, AnOctreeIsTheMessageThatOctomapDefines) {
  apps::OctomapMessage message = ToRos(apps::OctreeMessage{0.05, {1, -2, 3}}, {});
  message.header.frame_id = "map";
  EXPECT_STREQ(ros::message_traits::datatype(message), "octomap_msgs/Octomap");
  // Of "std_msgs/Header's checksum header\\nbool binary\\nstring id\\nfloat64 resolution\\nint8[]
  // data".
  EXPECT_STREQ(ros::message_traits::md5sum(message), "9a45536b45c5e409cd49f04bb2d9999f");
  // Header of 4 + 8 + 4 + 3 bytes, then 1, 4 + 6, 8 and 4 + 3.
  EXPECT_EQ(ros::serialization::serializationLength(message), 19u + 1u + 10u + 8u + 7u);
}

TEST(RosConversions, StatesHaveALevelAndValues) {
  const auto message = ToRos(
      apps::StateReport{apps::StateLevel::kError, "lost: dark", {{"a", "b"}}}, std_msgs::Header());
  ASSERT_EQ(message.status.size(), 1u);
  EXPECT_EQ(message.status[0].level, diagnostic_msgs::DiagnosticStatus::ERROR);
  EXPECT_EQ(message.status[0].message, "lost: dark");
  EXPECT_EQ(message.status[0].values.at(0).value, "b");
}

}  // namespace
}  // namespace highwall::ros_conversions_test
