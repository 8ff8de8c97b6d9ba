// What highwall_ros makes of images and readings that arrive, and of its parameters.
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include <highwall/frontend/input/image_pairer.h>
#include "ros/camera_stream.h"
#include "ros/node_options.h"
#include "ros/pose_covariance.h"
#include "support/message_of.h"

namespace highwall::ros_stream_test {
namespace {

using apps::CameraStream;

constexpr Stamp kMs = 1'000'000;

std::vector<Stamp> StampsOf(const std::vector<RgbdImage>& images) {
  std::vector<Stamp> stamps;
  for (const RgbdImage& image : images) stamps.push_back(image.stamp);
  return stamps;
}

TEST(ImagePairer, EqualStampsArePairedInEitherOrder) {
  ImagePairer pairer(0.02);
  EXPECT_TRUE(pairer.AddColour(10 * kMs, {}).empty());
  const std::vector<RgbdImage> first = pairer.AddDepth(10 * kMs, {});
  EXPECT_EQ(StampsOf(first), std::vector<Stamp>{10 * kMs});
  EXPECT_FALSE(first.front().depth_stamp);
  EXPECT_TRUE(pairer.AddDepth(43 * kMs, {}).empty());
  EXPECT_EQ(StampsOf(pairer.AddColour(43 * kMs, {})), std::vector<Stamp>{43 * kMs});
  EXPECT_EQ(pairer.unpaired(), 0u);
}

TEST(ImagePairer, TheNearestDepthImageIsTaken) {
  ImagePairer pairer(0.02);
  pairer.AddDepth(0, {});
  EXPECT_TRUE(pairer.AddColour(12 * kMs, {}).empty()) << "the next one may be nearer";
  const std::vector<RgbdImage> pair = pairer.AddDepth(20 * kMs, {});
  ASSERT_EQ(pair.size(), 1u);
  EXPECT_EQ(pair.front().depth_stamp, 20 * kMs);
}

TEST(ImagePairer, AColourImageWithoutDepthInTimeIsCounted) {
  ImagePairer pairer(0.02);
  pairer.AddColour(0, {});
  pairer.AddColour(100 * kMs, {});
  EXPECT_EQ(StampsOf(pairer.AddDepth(100 * kMs, {})), std::vector<Stamp>{100 * kMs});
  EXPECT_EQ(pairer.unpaired(), 1u);
}

TEST(ImagePairer, StampsThatDoNotAscendAreLeftOut) {
  ImagePairer pairer(0.02);
  pairer.AddColour(10 * kMs, {});
  pairer.AddColour(10 * kMs, {});
  pairer.AddColour(5 * kMs, {});
  EXPECT_EQ(pairer.out_of_order(), 2u);
}

TEST(ImagePairer, HoldsFewImages) {
  ImagePairer pairer(0.02);
  for (int i = 0; i < 100; ++i) pairer.AddColour(i * kMs, {});
  EXPECT_EQ(pairer.unpaired(), 100u - ImagePairer::kMostWaiting);
}

RgbdSensor SmallSensor() {
  RgbdSensor sensor;
  sensor.camera = {.width = 4, .height = 2, .fx = 4.0, .fy = 4.0, .cx = 1.5, .cy = 0.5};
  return sensor;
}

void AddImages(Stamp stamp, CameraStream& stream) {
  stream.AddColour(stamp, cv::Mat::zeros(2, 4, CV_8UC3));
  stream.AddDepth(stamp, cv::Mat(2, 4, CV_16UC1, cv::Scalar(1500)));
}

TEST(CameraStream, WholeNumbersAreMillimetresAndOtherDepthIsUnchanged) {
  CameraStream stream(SmallSensor(), {});
  AddImages(1, stream);
  EXPECT_FLOAT_EQ(stream.Next()->depth.at<float>(1, 3), 1.5f);
  stream.AddColour(2, cv::Mat::zeros(2, 4, CV_8UC3));
  stream.AddDepth(2, cv::Mat(2, 4, CV_32FC1, cv::Scalar(1.2345f)));
  EXPECT_EQ(stream.Next()->depth.at<float>(0, 0), 1.2345f);
}

TEST(CameraStream, ImagesOfAnotherSizeAreRefused) {
  CameraStream stream(SmallSensor(), {});
  EXPECT_THROW(stream.AddDepth(1, cv::Mat::zeros(4, 8, CV_16UC1)), InvalidArgument);
}

TEST(CameraStream, TheOldestImageIsDroppedAndTheRestRemainAfterTheEnd) {
  CameraStream stream(SmallSensor(), {.queue = 2});
  for (Stamp stamp = 1; stamp <= 3; ++stamp) AddImages(stamp, stream);
  stream.Stop();
  EXPECT_EQ(stream.dropped(), 1u);
  EXPECT_EQ(stream.Next()->stamp, 2);
  EXPECT_EQ(stream.Next()->stamp, 3);
  EXPECT_FALSE(stream.Next());
}

TEST(CameraStream, AnImageWaitsForTheReadingsAfterIt) {
  CameraStream stream(SmallSensor(), {.imu_lead = 0.05}, 0.01);
  AddImages(100 * kMs, stream);
  std::jthread imu([&] {
    for (Stamp stamp = 0; stamp <= 160 * kMs; stamp += 5 * kMs) {
      stream.AddImu({stamp, {0, 0, 0}, {0, 0, 9.8}});
    }
  });
  EXPECT_TRUE(stream.Next());
  const std::vector<ImuSample> readings = stream.TakeImu();
  EXPECT_EQ(readings.size(), 33u);
  EXPECT_TRUE(stream.TakeImu().empty());
}

TEST(CameraStream, ASilentImuHoldsUpNoImage) {
  CameraStream stream(SmallSensor(), {.queue = 10, .imu_lead = 0.05});
  for (Stamp stamp = 1; stamp <= 5; ++stamp) AddImages(stamp, stream);
  for (Stamp stamp = 1; stamp <= 5; ++stamp) EXPECT_EQ(stream.Next()->stamp, stamp);
}

TEST(NodeOptions, SettingsHaveTheNamesOfTheSwitches) {
  const apps::NodeOptions options = apps::ReadNodeOptions({{"out", "run"},
                                                           {"set.tracker.min_support", "25"},
                                                           {"resolution", "0.1"},
                                                           {"imu", "off"},
                                                           {"no_loops", "true"},
                                                           {"base_frame", "camera_link"}});
  const apps::SlamRunOptions run = apps::MakeOptions(options.slam);
  EXPECT_EQ(run.slam.tracker.min_support, 25);
  EXPECT_EQ(run.map.octree.resolution, 0.1);
  EXPECT_FALSE(run.slam.loops.enabled);
  EXPECT_TRUE(run.live);
  EXPECT_FALSE(options.link.imu);
  EXPECT_EQ(options.link.frames.base, "camera_link");
}

TEST(NodeOptions, FaultsAreNamed) {
  using apps::ReadNodeOptions;
  const auto message = [](const apps::Parameters& parameters) {
    return testing::MessageOf<InvalidArgument>([&] { ReadNodeOptions(parameters); });
  };
  EXPECT_EQ(message({{"out", "run"}, {"resolution", "-1"}}),
            "~resolution is '-1': must be a number above 0, at most 10");
  EXPECT_EQ(message({{"out", "run"}, {"no_map", "1"}}), "~no_map is '1': must be true or false");
  EXPECT_EQ(message({}), "~out names the folder for the results: set it");
  EXPECT_EQ(message({{"out", "run"}, {"localize", "true"}}),
            "~localize needs a map: set ~load_map");
  EXPECT_THROW(ReadNodeOptions({{"out", "run"}, {"set.tracker.nothing", "1"}}), InvalidArgument);
  EXPECT_THROW(ReadNodeOptions({{"out", "run"}, {"imu", "some"}}), InvalidArgument);
  EXPECT_THROW(ReadNodeOptions({{"out", "run"}, {"sensor", "none"}}), InvalidArgument);
}

TEST(CovarianceOfAPose, TurnsFromTheAxesOfTheCameraToThoseOfTheWorld) {
  PoseUncertainty uncertainty;
  uncertainty.in_map(0, 0) = 4e-4;
  uncertainty.in_map(3, 3) = 1e-6;
  // x of the camera is y of the world.
  const Pose T_WC(Eigen::Quaterniond(std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)), {1, 2, 3});
  const apps::PoseCovariance covariance = apps::InWorld(uncertainty, T_WC);
  EXPECT_NEAR(covariance(0, 0), 1e-10, 1e-18);
  EXPECT_NEAR(covariance(1, 1), 4e-4 + 1e-10, 1e-18);
  EXPECT_NEAR(covariance(4, 4), 1e-6 + 1e-10, 1e-18);
}

TEST(CovarianceOfAPose, ARotationMovesAnotherPointOfTheBody) {
  const apps::PoseCovariance identity = 1e-6 * apps::PoseCovariance::Identity();
  const apps::PoseCovariance covariance = apps::MovedBy({0.0, 0.0, 2.0}, identity);
  EXPECT_NEAR(covariance(0, 0), 5e-6, 1e-18);
  EXPECT_NEAR(covariance(2, 2), 1e-6, 1e-18);
  EXPECT_NEAR(covariance(0, 4), 2e-6, 1e-18);
}

}  // namespace
}  // namespace highwall::ros_stream_test
