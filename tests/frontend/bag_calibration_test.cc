// The cameras that a bag states.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/frontend/input/open_dataset.h>

#include "support/bag_files.h"
#include "support/recorded_scene.h"
#include "support/temporary_directory.h"

namespace highwall::bag_calibration_test {
namespace {

using testing::MessagesOf;
using testing::RecordedScene;
using testing::WrittenMessage;

std::unique_ptr<Dataset> Open(const testing::TemporaryDirectory& folder,
                              const std::vector<WrittenMessage>& messages) {
  testing::WriteText(folder / "a.bag", testing::RosbagOf(messages));
  return OpenDataset(folder / "a.bag");
}

// As the drivers of uncalibrated sensors state both.
TEST(BagCalibration, DepthWithTheCameraOfColourIsMovedWhereTransformsSayThatItIsElsewhere) {
  RecordedScene scene{.depth = "/camera/depth/image_raw", .depth_frame = "depth_optical"};
  scene.camera.k1 = 0.0;
  for (const double baseline : {0.025, 0.0}) {
    std::vector<WrittenMessage> messages = MessagesOf(scene);
    messages.push_back({"/camera/depth/camera_info", "sensor_msgs/CameraInfo", testing::kSceneStart,
                        CameraInfoMessage(scene.how, "depth_optical", scene.camera)});
    const Pose T_CD(Eigen::Quaterniond(1, 0, 0, 0), {baseline, 0.0, 0.0});
    messages.push_back({"/tf_static", "tf2_msgs/TFMessage", testing::kSceneStart,
                        TransformsMessage(scene.how, {{"color_optical", "depth_optical", T_CD}})});
    const testing::TemporaryDirectory folder;
    const auto dataset = Open(folder, messages);
    const auto& depth_camera = dataset->calibration()->sensor.depth_camera;
    ASSERT_EQ(depth_camera.has_value(), baseline > 0.0);
    if (depth_camera) {
      EXPECT_EQ(depth_camera->T_CD.p(), T_CD.p());
    }
    EXPECT_TRUE(dataset->warnings().empty());
  }
}

TEST(BagCalibration, ADamagedFirstMessageIsPassedOver) {
  std::vector<WrittenMessage> messages = MessagesOf({});
  for (const char* topic : {"/camera/color/camera_info", "/camera/imu"}) {
    const auto first = std::ranges::find(messages, topic, &WrittenMessage::topic);
    ASSERT_NE(first, messages.end());
    WrittenMessage damaged = *first;
    damaged.bytes.resize(damaged.bytes.size() / 2);
    messages.insert(first, damaged);
  }
  const testing::TemporaryDirectory folder;
  const auto dataset = Open(folder, messages);
  ASSERT_NE(dataset->calibration(), nullptr);
  EXPECT_EQ(dataset->calibration()->sensor.camera.fx, 60.0);
}

TEST(BagCalibration, ALensIsKeptWhereTheCameraIsStatedInAnotherSize) {
  RecordedScene scene;
  scene.camera.width = 128;
  scene.camera.height = 96;
  scene.camera.fx = scene.camera.fy = 120.0;
  scene.camera.cx = 63.5;
  const testing::TemporaryDirectory folder;
  const auto dataset = Open(folder, MessagesOf(scene));
  const PinholeCamera& camera = dataset->calibration()->sensor.camera;
  EXPECT_EQ(camera.width, 64);
  EXPECT_EQ(camera.fx, 60.0);
  EXPECT_EQ(camera.cx, 31.5);
  EXPECT_EQ(camera.k1, 0.01);
}

}  // namespace
}  // namespace highwall::bag_calibration_test
