// highwall_ros as a robot uses it: with a master on the loopback address, and a camera that does
// not wait.
#include <signal.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/mapping/octomap_builder.h>

#include "ros_peer.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/free_port.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::ros_node_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::BackgroundProgram;
using testing::ReadText;

constexpr double kFps = 10.0;
constexpr int kFrames = 40;
constexpr double kSame = 1e-3;  // [m]

class RosNode : public ::testing::Test {
 protected:
  RosNode() {
    const std::string port = std::to_string(testing::FreePort());
    const std::string folder = (folder_ / "ros").string();
    for (const auto& [name, value] :
         {std::pair<const char*, std::string>{"ROS_MASTER_URI", "http://127.0.0.1:" + port},
          {"ROS_IP", "127.0.0.1"},
          {"ROS_HOME", folder},
          {"ROS_LOG_DIR", folder}}) {
      ::setenv(name, value.c_str(), 1);
    }
    ::unsetenv("ROS_HOSTNAME");
    master_ = std::make_unique<BackgroundProgram>(testing::kRoscore,
                                                  std::vector<std::string>{"-p", port});
    simulate::SimulationOptions options;
    options.camera = {
        .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
    options.fps = kFps;
    options.duration = kFrames / kFps;
    simulate::WriteTum(simulate::SimulateRoom(options), dataset());
    const RgbdSensor sensor = ReadSensor(dataset() / "calibration.yaml").sensor;
    camera_ = sensor.camera;
    images_ = OpenDataset(dataset(), sensor);
    const VideoSpan span{images_->stamp(0), images_->stamp(images_->size() - 1)};
    readings_ = ReadImu(dataset() / "imu.csv", span).samples;
    peer_ = std::make_unique<RosPeer>();
  }
  ~RosNode() override {
    peer_.reset();
    if (node_) node_->Send(SIGKILL);
    master_->Send(SIGINT);  // it stops the processes that it has started
    master_->ExitCode();
  }

  // imu: as --imu; empty: its default.
  // config: file name in the folder of the dataset.
  void StartNode(const std::string& imu = "", const std::string& config = "calibration.yaml") {
    RosPeer::SetParameter("/highwall/out", run().string());
    RosPeer::SetParameter("/highwall/config", (dataset() / config).string());
    RosPeer::SetParameter("/highwall/deterministic", true);
    RosPeer::SetParameter("/highwall/queue", 1000);
    RosPeer::SetParameter("/highwall/set/tracker/min_support", 25);
    RosPeer::SetParameter("/highwall/imu", imu);
    node_ = std::make_unique<BackgroundProgram>(testing::kHighwallRos, std::vector<std::string>{});
    ASSERT_TRUE(peer_->WaitForNode(camera_, "camera", imu != "off"));
  }
  // Publishes the frames and readings of [begin, end) at the pace of their stamps.
  void Play(std::size_t begin, std::size_t end) {
    const auto start = std::chrono::steady_clock::now();
    const Stamp first = images_->stamp(begin);
    const auto wait_until = [&](Stamp stamp) {
      std::this_thread::sleep_until(start + std::chrono::nanoseconds(stamp - first));
    };
    const Stamp last =
        end < images_->size() ? images_->stamp(end) : images_->stamp(end - 1) + FromSeconds(0.2);
    for (std::size_t i = begin; i < end; ++i) {
      const Stamp stamp = images_->stamp(i);
      PublishReadings(stamp);
      const std::optional<RgbdImage> image = images_->Load(i);
      wait_until(stamp);
      peer_->PublishImages(stamp, image->bgr, image->depth);
    }
    PublishReadings(last);
  }
  void PublishReadings(Stamp until) {
    for (; reading_ < readings_.size() && readings_[reading_].stamp <= until; ++reading_) {
      const ImuSample& sample = readings_[reading_];
      peer_->PublishImu(sample.stamp, sample.gyroscope, sample.accelerometer);
    }
  }
  // Waits for a condition; false after a minute.
  template <class Condition>
  static bool Waited(const Condition& condition) {
    for (int i = 0; i < 3000 && !condition(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return condition();
  }
  bool HearsPoses(std::size_t count) const {
    return Waited([&] { return peer_->heard().poses.size() >= count; });
  }
  // Waits until the node is ready for the images of another run.
  bool BeginsRun(const std::string& doing, const fs::path& folder) const {
    return Waited([&] {
      const std::string state = peer_->heard().state;
      return state.starts_with("waiting for images: " + doing) && state.ends_with(folder.string());
    });
  }
  fs::path dataset() const { return folder_ / "dataset"; }
  fs::path run() const { return folder_ / "run"; }

  const testing::TemporaryDirectory folder_;
  std::unique_ptr<BackgroundProgram> master_, node_;
  std::unique_ptr<const Dataset> images_;
  std::vector<ImuSample> readings_;
  std::unique_ptr<RosPeer> peer_;
  PinholeCamera camera_;
  std::size_t reading_ = 0;
};

// Distance of two poses of a camera; infinite if one is missing.
double DistanceTo(const std::map<Stamp, apps::UncertainPose>& heard, const StampedPose& expected) {
  for (const auto& [stamp, uncertain] : heard) {  // the file has microseconds
    if (std::abs(stamp - expected.stamp) < 1'000) {
      return (uncertain.pose.p() - expected.pose.p()).norm();
    }
  }
  return std::numeric_limits<double>::infinity();
}

// A settings file of ORB-SLAM2 does not state the size.
TEST_F(RosNode, ACalibrationWithoutASizeIsForTheImagesOfCameraInfo) {
  testing::WriteText(
      dataset() / "orb.yaml",
      fmt::format("%YAML:1.0\nCamera.fx: {}\nCamera.fy: {}\nCamera.cx: {}\nCamera.cy: {}\n"
                  "DepthMapFactor: 1000.0\n",
                  camera_.fx, camera_.fy, camera_.cx, camera_.cy));
  StartNode("off", "orb.yaml");
  Play(0, 10);
  EXPECT_TRUE(HearsPoses(10));
  node_->Send(SIGINT);
  EXPECT_EQ(node_->ExitCode(), 0);
}

TEST_F(RosNode, HeardPosesAreThoseOfTheRecordingAndNoneIsLost) {
  StartNode();
  Play(0, kFrames);
  EXPECT_TRUE(HearsPoses(kFrames));
  node_->Send(SIGINT);
  EXPECT_EQ(node_->ExitCode(), 0);
  const testing::Outcome offline = testing::RunProgram(
      testing::kHighwallProgram,
      "slam --dataset dataset --out offline --deterministic --set tracker.min_support=25",
      folder_.path());
  ASSERT_EQ(offline.exit_code, 0) << offline.err;
  const Trajectory expected = ReadTumTrajectory(folder_ / "offline/trajectory_causal.txt");
  const Heard heard = peer_->heard();
  ASSERT_EQ(expected.size(), kFrames);
  EXPECT_EQ(heard.poses.size(), kFrames);
  EXPECT_EQ(heard.odometry.size(), kFrames);
  for (const StampedPose& pose : expected) EXPECT_LT(DistanceTo(heard.poses, pose), kSame);
  for (const char* file : {"trajectory_causal.txt", "trajectory.txt", "map.bt"}) {
    EXPECT_EQ(ReadText(run() / file), ReadText(folder_ / "offline" / file)) << file;
  }
  const json report = json::parse(ReadText(run() / "run.json"));
  EXPECT_EQ(report["complete"], true);
  EXPECT_EQ(report["frames"], kFrames);
  EXPECT_EQ(report["dropped_frames"], 0);
  EXPECT_TRUE(report.contains("imu"));
}

TEST_F(RosNode, PublishesFramesCovarianceAndMaps) {
  StartNode();
  Play(0, kFrames);
  EXPECT_TRUE(HearsPoses(kFrames));
  node_->Send(SIGTERM);
  EXPECT_EQ(node_->ExitCode(), 0);
  const std::string data = OctomapBuilder::Read(run() / "map.bt").BinaryData();
  const std::vector<std::int8_t> octree(data.begin(), data.end());
  EXPECT_TRUE(Waited([&] { return peer_->heard().octree.data == octree; }));
  const std::size_t poses = ReadTumTrajectory(run() / "trajectory.txt").size();
  EXPECT_TRUE(Waited([&] { return peer_->heard().path_poses == poses; }));
  const Heard heard = peer_->heard();
  EXPECT_EQ(heard.base, "camera");
  EXPECT_EQ(heard.state, "tracking");
  for (const auto& [stamp, pose] : heard.poses) {
    ASSERT_TRUE(heard.T_WO.contains(stamp) && heard.T_OB.contains(stamp));
    const Pose through_odom = heard.T_WO.at(stamp) * heard.T_OB.at(stamp);
    EXPECT_LT((through_odom.p() - pose.pose.p()).norm(), 1e-9);
    EXPECT_GT(pose.covariance.llt().matrixL().determinant(), 0.0);
    EXPECT_LT(std::sqrt(pose.covariance(0, 0)), 0.5);
  }
  EXPECT_GT(heard.cloud_points, 1000u);
  EXPECT_GE(heard.grids, 1u);
}

TEST_F(RosNode, ServicesSaveResetAndLocalize) {
  constexpr std::size_t kPart = kFrames / 4;
  StartNode("off");
  Play(0, kPart);
  ASSERT_TRUE(HearsPoses(kPart));
  std::jthread player([this] { Play(kPart, 2 * kPart); });
  const apps::Answer saved = RosPeer::Call("highwall/save");
  EXPECT_TRUE(saved.success) << saved.message;
  player.join();
  EXPECT_TRUE(fs::exists(run() / "map.hwmap"));
  ASSERT_TRUE(HearsPoses(2 * kPart));
  EXPECT_FALSE(RosPeer::Call("highwall/localize", false).success);
  EXPECT_TRUE(RosPeer::Call("highwall/localize", true).success);
  ASSERT_TRUE(BeginsRun("localizing", run().string() + "_2"));
  Play(2 * kPart, 3 * kPart);
  ASSERT_TRUE(HearsPoses(3 * kPart));
  EXPECT_FALSE(RosPeer::Call("highwall/save").success);
  EXPECT_TRUE(RosPeer::Call("highwall/reset").success);
  ASSERT_TRUE(BeginsRun("mapping", run().string() + "_3"));
  Play(3 * kPart, 4 * kPart);
  ASSERT_TRUE(HearsPoses(4 * kPart));
  RosPeer::Shutdown("/highwall");
  EXPECT_EQ(node_->ExitCode(), 0);
  for (const char* suffix : {"", "_2", "_3"}) {
    const json report = json::parse(ReadText(run().string() + suffix + "/run.json"));
    EXPECT_EQ(report["complete"], true) << suffix;
    EXPECT_EQ(report["lost_frames"], 0) << suffix;
  }
  EXPECT_FALSE(fs::exists(run().string() + "_2/map.hwmap"));
}

TEST_F(RosNode, AWrongParameterIsNamedInOneLine) {
  RosPeer::SetParameter("/highwall/out", run().string());
  RosPeer::SetParameter("/highwall/queues", 3);
  const testing::Outcome unknown = testing::RunProgram(testing::kHighwallRos, "");
  testing::ExpectRefused(unknown, 2, {"there is no parameter ~queues; did you mean 'queue'?"});
  EXPECT_FALSE(fs::exists(run()));
}

TEST_F(RosNode, EndsWithoutAnImageInOrder) {
  StartNode();
  node_->Send(SIGINT);
  EXPECT_EQ(node_->ExitCode(), 0);
  EXPECT_FALSE(fs::exists(run()));
}

}  // namespace
}  // namespace highwall::ros_node_test
