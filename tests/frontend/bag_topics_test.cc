// Which topics of a bag are read.
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

#include "input/bag_topics.h"
#include "support/bag_files.h"
#include "support/message_of.h"
#include "support/recorded_scene.h"
#include "support/temporary_directory.h"

namespace highwall::bag_topics_test {
namespace {

using testing::ExpectError;
using testing::ImageMessage;
using testing::ImuMessage;
using testing::SceneColour;
using testing::SceneDepth;
using testing::WrittenMessage;

constexpr auto kHow = testing::Serialization::kRos1;

WrittenMessage Colour(const std::string& topic, const std::string& frame = "colour") {
  return {topic, "sensor_msgs/Image", 1, ImageMessage(kHow, 1, frame, SceneColour(1), "rgb8")};
}
WrittenMessage Grey(const std::string& topic) {
  const cv::Mat grey(48, 64, CV_8UC1, cv::Scalar(7));
  return {topic, "sensor_msgs/Image", 1, ImageMessage(kHow, 1, "infra", grey, "mono8")};
}
WrittenMessage Depth(const std::string& topic, const std::string& frame = "depth") {
  return {topic, "sensor_msgs/Image", 1, ImageMessage(kHow, 1, frame, SceneDepth(1), "16UC1")};
}
WrittenMessage Imu(const std::string& topic) {
  return {topic, "sensor_msgs/Imu", 1,
          ImuMessage(kHow, 1, "imu", Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero())};
}

// Returns what is chosen, as --topics writes it.
std::string Chosen(const std::vector<WrittenMessage>& messages, const std::string& wanted = "",
                   bool* is_registered = nullptr) {
  const testing::TemporaryDirectory folder;
  testing::WriteText(folder / "a.bag", testing::RosbagOf(messages));
  const auto bag = OpenBag(folder / "a.bag");
  const BagTopics topics = ReadBagTopics(wanted);
  const BagImageTopics images = ChooseImages(*bag, topics);
  if (is_registered != nullptr) *is_registered = images.is_registered;
  const auto name = [&](std::uint32_t topic) { return bag->topics()[topic].name; };
  BagTopics chosen{.colour = name(images.colour.topic), .depth = name(images.depth.topic)};
  if (const auto imu = ChooseImu(*bag, topics, chosen.colour)) {
    if (imu->IsOne()) {
      chosen.imu = name(imu->gyroscope);
    } else {
      chosen.gyroscope = name(imu->gyroscope);
      chosen.accelerometer = name(imu->accelerometer);
    }
  }
  return ToText(chosen);
}

TEST(BagTopics, DepthAlignedToColourComesFirst) {
  bool is_registered = false;
  EXPECT_EQ(Chosen({Colour("/camera/color/image_raw"), Grey("/camera/infra1/image_rect_raw"),
                    Depth("/camera/depth/image_rect_raw"),
                    Depth("/camera/aligned_depth_to_color/image_raw"), Imu("/camera/imu")},
                   "", &is_registered),
            "colour=/camera/color/image_raw,depth=/camera/aligned_depth_to_color/image_raw,"
            "imu=/camera/imu");
  EXPECT_TRUE(is_registered);
  EXPECT_EQ(Chosen({Depth("/camera/depth/image"), Depth("/camera/depth_registered/image_raw"),
                    Colour("/camera/rgb/image_color")}),
            "colour=/camera/rgb/image_color,depth=/camera/depth_registered/image_raw");
  EXPECT_EQ(Chosen({Colour("/rgb/image_raw"), Depth("/depth/image_raw"),
                    Depth("/depth_to_rgb/image_raw"), Imu("/imu")}),
            "colour=/rgb/image_raw,depth=/depth_to_rgb/image_raw,imu=/imu");
}

// Of two cameras, whichever has more images of one kind.
TEST(BagTopics, DepthIsThatOfTheCameraThatColourIsOf) {
  const WrittenMessage front = Colour("/front/color/image_raw", "front_color");
  const WrittenMessage rear = Depth("/rear/aligned_depth_to_color/image_raw", "rear_color");
  const std::vector<WrittenMessage> all{
      front, front, Colour("/rear/color/image_raw", "rear_color"),
      rear,  rear,  Depth("/front/aligned_depth_to_color/image_raw", "front_color")};
  EXPECT_EQ(Chosen(all),
            "colour=/front/color/image_raw,depth=/front/aligned_depth_to_color/image_raw");
  EXPECT_EQ(Chosen(all, "colour=/rear/color/image_raw"),
            "colour=/rear/color/image_raw,depth=/rear/aligned_depth_to_color/image_raw");
  bool is_registered = true;
  Chosen({front, rear}, "", &is_registered);
  EXPECT_FALSE(is_registered) << "to the colour of another camera";
}

TEST(BagTopics, DepthInTheFrameOfColourIsRegisteredToIt) {
  bool is_registered = false;
  EXPECT_EQ(Chosen({Colour("/oak/rgb/image", "oak_rgb"), Depth("/oak/tof/depth", "oak_tof"),
                    Depth("/oak/stereo/image", "oak_rgb")},
                   "", &is_registered),
            "colour=/oak/rgb/image,depth=/oak/stereo/image");
  EXPECT_TRUE(is_registered);
  Chosen({Colour("/oak/rgb/image", "oak_rgb"), Depth("/oak/tof/depth", "oak_tof")}, "",
         &is_registered);
  EXPECT_FALSE(is_registered);
}

TEST(BagTopics, TheStreamsOfARealSenseAreFound) {
  const std::string device = "/device_0/sensor_";
  bool is_registered = true;
  EXPECT_EQ(
      Chosen({Grey(device + "0/Infrared_1/image/data"), Depth(device + "0/Depth_0/image/data", "0"),
              Colour(device + "1/Color_0/image/data", "0"), Imu(device + "2/Accel_0/imu/data"),
              Imu(device + "2/Gyro_0/imu/data")},
             "", &is_registered),
      "colour=/device_0/sensor_1/Color_0/image/data,"
      "depth=/device_0/sensor_0/Depth_0/image/data,"
      "gyroscope=/device_0/sensor_2/Gyro_0/imu/data,"
      "accelerometer=/device_0/sensor_2/Accel_0/imu/data");
  EXPECT_FALSE(is_registered);
}

TEST(BagTopics, AGreyCameraServesWhereThereIsNoColour) {
  EXPECT_EQ(Chosen({Grey("/camera/infra1/image_rect_raw"), Depth("/camera/depth/image_rect_raw")}),
            "colour=/camera/infra1/image_rect_raw,depth=/camera/depth/image_rect_raw");
}

TEST(BagTopics, AnImuOfTheSameDeviceComesFirst) {
  const WrittenMessage other = Imu("/mavros/imu/data");
  EXPECT_EQ(Chosen({Colour("/camera/camera/color/image"), Depth("/camera/camera/depth/image"),
                    other, other, Imu("/camera/camera/imu"), Imu("/camera/camera/gyro/sample"),
                    Imu("/camera/camera/accel/sample")}),
            "colour=/camera/camera/color/image,depth=/camera/camera/depth/image,"
            "imu=/camera/camera/imu");
  EXPECT_EQ(Chosen({Colour("/camera/color/image"), Depth("/camera/depth/image"), other, other,
                    Imu("/camera/gyro/sample"), Imu("/camera/accel/sample")}),
            "colour=/camera/color/image,depth=/camera/depth/image,"
            "gyroscope=/camera/gyro/sample,accelerometer=/camera/accel/sample")
      << "before that of the vehicle";
  // One sensor is no IMU.
  EXPECT_EQ(Chosen({Colour("/c"), Depth("/d"), Imu("/camera/gyro/sample")}), "colour=/c,depth=/d");
}

TEST(BagTopics, ThoseThatAreAskedForAreTaken) {
  const std::vector<WrittenMessage> all{Colour("/left/color"),
                                        Colour("/right/image"),
                                        Depth("/left/aligned_depth"),
                                        Depth("/right/depth"),
                                        Imu("/imu"),
                                        Imu("/g"),
                                        Imu("/a")};
  EXPECT_EQ(Chosen(all, "colour=/right/image,depth=/right/depth,gyroscope=/g,accelerometer=/a"),
            "colour=/right/image,depth=/right/depth,gyroscope=/g,accelerometer=/a");
  EXPECT_EQ(Chosen(all, "depth=/right/depth,imu=/a"),
            "colour=/left/color,depth=/right/depth,imu=/a");
}

TEST(BagTopics, AnErrorListsTheTopicsWithTheirTypes) {
  const auto expect = [](const std::vector<WrittenMessage>& messages, const std::string& wanted,
                         const std::string& message) {
    ExpectError<IoError>("a.bag: " + message, [&] { Chosen(messages, wanted); });
  };
  const std::string list =
      "; it has /c (sensor_msgs/Image), /d (sensor_msgs/Image), "
      "/i (sensor_msgs/Imu)";
  const std::vector<WrittenMessage> all{Colour("/c"), Depth("/d"), Imu("/i")};
  expect(all, "colour=/x", "has no topic /x" + list);
  expect(all, "depth=/i", "its topic /i holds no images" + list);
  expect(all, "imu=/c", "its topic /c holds no readings of an IMU" + list);
  expect({Depth("/d")}, "", "holds no colour images; it has /d (sensor_msgs/Image)");
  expect({Colour("/c")}, "", "holds no depth images in 16UC1, mono16 or 32FC1; it has /c");
  const WrittenMessage bayer{
      "/b", "sensor_msgs/Image", 1,
      ImageMessage(kHow, 1, "b", cv::Mat(48, 64, CV_8UC1, cv::Scalar(7)), "bayer_grbg8")};
  expect({bayer, Depth("/d")}, "",
         "holds no colour images that are read (/b has bayer_grbg8); it has /b");
  expect({}, "", "holds no message");
}

TEST(BagTopics, TheirTextIsChecked) {
  const std::string text = "colour=/a,depth=/b,gyroscope=/c,accelerometer=/d";
  EXPECT_EQ(ToText(ReadBagTopics(text)), text);
  EXPECT_EQ(ReadBagTopics("imu=/c").imu, "/c");
  EXPECT_EQ(ToText(ReadBagTopics("")), "");
  for (const auto& [wrong, message] :
       {std::pair("color=/a",
                  "'color' is none of the topics colour, depth, imu, gyroscope and accelerometer"),
        {"colour", "colour needs a topic, such as colour=/name"},
        {"colour=", "colour needs a topic"},
        {"colour=/a,colour=/b", "colour is given twice"},
        {"gyroscope=/a", "gyroscope and accelerometer need each other"},
        {"imu=/a,gyroscope=/b,accelerometer=/c", "imu has both sensors"}}) {
    ExpectError(message, [&, text = wrong] { ReadBagTopics(text); });
  }
}

}  // namespace
}  // namespace highwall::bag_topics_test
