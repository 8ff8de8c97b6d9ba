// highwall info, slam, convert, map and imu-noise on bags of ROS.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <highwall/frontend/input/open_dataset.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "run/opened_dataset.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/bag_files.h"
#include "support/recorded_scene.h"
#include "support/run_program.h"
#include "support/temporary_directory.h"
#include "support/test_paths.h"

namespace highwall::apps::bag_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::ExpectRefused;
using testing::Outcome;
using testing::ReadText;
using testing::Serialization;
using testing::TemporaryDirectory;
using testing::WriteText;
using testing::WrittenMessage;

Outcome Highwall(const std::string& arguments) {
  return testing::RunProgram(testing::kHighwallProgram, arguments);
}

std::string Quoted(const fs::path& path) {
  return "'" + path.string() + "'";
}

// The images and readings of a folder of TUM RGB-D as messages.
std::vector<WrittenMessage> MessagesOfTum(const fs::path& folder, Serialization how) {
  const OpenedDataset opened = OpenWithConfig("", folder);
  const auto& tum = dynamic_cast<const TumDataset&>(*opened.images);
  const std::string camera = "/camera/color/", depth = "/camera/aligned_depth_to_color/";
  std::vector<WrittenMessage> messages{
      {camera + "camera_info", "sensor_msgs/CameraInfo", tum.stamp(0),
       CameraInfoMessage(how, "color", opened.config.sensor.camera)}};
  for (const TumImageFile& file : tum.colour_files()) {
    messages.push_back(
        {camera + "image_raw", "sensor_msgs/Image", file.stamp,
         ImageMessage(how, file.stamp, "color", cv::imread(file.path.string()), "bgr8")});
  }
  for (const TumImageFile& file : tum.depth_files()) {
    messages.push_back(
        {depth + "image_raw", "sensor_msgs/Image", file.stamp,
         ImageMessage(how, file.stamp, "color",
                      cv::imread(file.path.string(), cv::IMREAD_UNCHANGED), "16UC1")});
  }
  if (!tum.imu_file()) return messages;
  for (const ImuSample& sample : tum.ReadImu({tum.stamp(0), tum.stamp(tum.size() - 1)}).samples) {
    messages.push_back(
        {"/camera/imu", "sensor_msgs/Imu", sample.stamp,
         ImuMessage(how, sample.stamp, "imu", sample.gyroscope, sample.accelerometer)});
  }
  return messages;
}

// Two seconds of a walk with an IMU.
class BagsOfAWalk : public ::testing::Test {
 protected:
  void SetUp() override {
    simulate::SimulationOptions options;
    options.camera = {
        .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
    options.fps = 6.0;
    options.duration = 2.0;
    simulate::WriteTum(simulate::SimulateRoom(options), tum());
  }

  fs::path tum() const { return folder_ / "tum"; }
  fs::path run(const std::string& name) const { return folder_ / ("run_" + name); }

  TemporaryDirectory folder_;
};

TEST_F(BagsOfAWalk, EveryContainerGivesTheTrajectoryOfTheFolderToTheByte) {
  const auto ros1 = MessagesOfTum(tum(), Serialization::kRos1);
  const auto ros2 = MessagesOfTum(tum(), Serialization::kCdr);
  WriteText(folder_ / "none.bag", testing::RosbagOf(ros1));
  WriteText(folder_ / "bz2.bag", testing::RosbagOf(ros1, "bz2"));
  WriteText(folder_ / "lz4.bag", testing::RosbagOf(ros1, "lz4"));
  WriteText(folder_ / "zstd.mcap", testing::McapOf(ros2, "zstd"));
  fs::create_directory(folder_ / "ros2");
  WriteText(folder_ / "ros2/metadata.yaml", "rosbag2_bagfile_information:\n");
  testing::WriteSqliteBag(folder_ / "ros2/walk_0.db3", ros2);
  const std::string how =
      " --deterministic --no-map --config " + Quoted(tum() / "calibration.yaml") + " --out ";
  const Outcome folder = Highwall("slam " + Quoted(tum()) + how + Quoted(run("tum")));
  ASSERT_EQ(folder.exit_code, 0) << folder.err;
  const std::string expected = ReadText(run("tum") / "trajectory.txt");
  EXPECT_EQ(testing::CountLines(expected), 1U + 12U);  // a heading
  for (const char* name : {"none.bag", "bz2.bag", "lz4.bag", "zstd.mcap", "ros2"}) {
    const Outcome outcome = Highwall("slam " + Quoted(folder_ / name) + how + Quoted(run(name)));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(ReadText(run(name) / "trajectory.txt"), expected) << name;
    EXPECT_TRUE(Contains(outcome.err,
                         "highwall slam: topics colour=/camera/color/image_raw,"
                         "depth=/camera/aligned_depth_to_color/image_raw,imu=/camera/imu\n"))
        << outcome.err;
    EXPECT_EQ(json::parse(ReadText(run(name) / "run.json"))["imu"]["readings"],
              json::parse(ReadText(run("tum") / "run.json"))["imu"]["readings"]);
  }
  // A run finds its bag again.
  const Outcome map =
      Highwall("map " + Quoted(run("lz4.bag")) + " --out " + Quoted(folder_ / "map"));
  EXPECT_EQ(map.exit_code, 0) << map.err;
}

TEST_F(BagsOfAWalk, ConvertWritesTheFolderThatTheBagWasMadeOf) {
  WriteText(folder_ / "walk.mcap",
            testing::McapOf(MessagesOfTum(tum(), Serialization::kBigEndianCdr), "lz4"));
  const Outcome outcome =
      Highwall("convert " + Quoted(folder_ / "walk.mcap") + " " + Quoted(folder_ / "copy") +
               " --config " + Quoted(tum() / "calibration.yaml"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "frames      12 of 12, depth factor 5000")) << outcome.out;
  EXPECT_TRUE(Contains(outcome.err, "highwall convert: topics colour=")) << outcome.err;
  const OpenedDataset a = OpenWithConfig("", tum()), b = OpenWithConfig("", folder_ / "copy");
  ASSERT_EQ(a.images->size(), b.images->size());
  for (std::size_t i = 0; i < a.images->size(); ++i) {
    EXPECT_EQ(a.images->stamp(i), b.images->stamp(i));
    EXPECT_EQ(a.images->depth_stamp(i), b.images->depth_stamp(i));
    const auto from = a.images->Load(i), to = b.images->Load(i);
    ASSERT_TRUE(from && to);
    EXPECT_EQ(cv::norm(from->bgr, to->bgr, cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::norm(from->depth, to->depth, cv::NORM_INF), 0.0);
  }
  const VideoSpan span{a.images->stamp(0), a.images->stamp(a.images->size() - 1)};
  const ImuRecording from = a.images->ReadImu(span), to = b.images->ReadImu(span);
  ASSERT_EQ(from.samples.size(), to.samples.size());
  for (std::size_t i = 0; i < from.samples.size(); ++i) {
    EXPECT_EQ(from.samples[i].stamp, to.samples[i].stamp);
    EXPECT_EQ(from.samples[i].gyroscope, to.samples[i].gyroscope);
    EXPECT_EQ(from.samples[i].accelerometer, to.samples[i].accelerometer);
  }
}

// Depth of its own camera, whose pose and whose IMU /tf_static states.
TEST(ConvertOfABag, WritesDepthThatItRegistered) {
  const TemporaryDirectory folder;
  testing::RecordedScene scene{.depth = "/camera/depth/image_raw", .depth_frame = "depth"};
  scene.camera.k1 = 0.0;
  std::vector<WrittenMessage> messages = testing::MessagesOf(scene);
  PinholeCamera depth = scene.camera;
  depth.fx = 58.0;
  messages.push_back({"/camera/depth/camera_info", "sensor_msgs/CameraInfo", testing::kSceneStart,
                      CameraInfoMessage(scene.how, "depth", depth)});
  const Pose T_CD(Eigen::Quaterniond(1, 0, 0, 0), {0.05, 0.0, 0.0});
  const Pose T_CB(Eigen::Quaterniond(0, 1, 0, 0), {0.0, 0.0, 0.3});
  messages.push_back({"/tf_static", "tf2_msgs/TFMessage", testing::kSceneStart,
                      TransformsMessage(scene.how, {{"color_optical", "depth", T_CD},
                                                    {"color_optical", "imu_frame", T_CB}})});
  WriteText(folder / "a.bag", testing::RosbagOf(messages));
  const Outcome outcome =
      Highwall("convert " + Quoted(folder / "a.bag") + " " + Quoted(folder / "copy"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "imu         121 readings in imu.csv")) << outcome.out;
  const OpenedDataset a = OpenWithConfig("", folder / "a.bag");
  const OpenedDataset b = OpenWithConfig("", folder / "copy");
  EXPECT_TRUE(a.config.sensor.depth_camera.has_value());
  EXPECT_FALSE(b.config.sensor.depth_camera.has_value());
  ASSERT_TRUE(b.config.imu.has_value());
  EXPECT_TRUE(b.config.imu->T_BC.Matrix().isApprox(T_CB.Inverse().Matrix(), 1e-8));
  for (std::size_t i = 0; i < a.images->size(); ++i) {
    const auto from = a.images->Load(i), to = b.images->Load(i);
    ASSERT_TRUE(from && to);
    EXPECT_GT(cv::countNonZero(from->depth), 500);
    EXPECT_EQ(cv::norm(from->bgr, to->bgr, cv::NORM_INF), 0.0);
    // It is stored by a factor of at least 1000, and inside a surface it is interpolated.
    EXPECT_LE(cv::norm(from->depth, to->depth, cv::NORM_INF), 0.5001 / 1000.0);
  }
}

TEST(InfoOnABag, NamesFormatTopicsAndCalibration) {
  const TemporaryDirectory folder;
  WriteText(folder / "a.bag", testing::RosbagOf(testing::MessagesOf({})));
  const std::string topics =
      "colour=/camera/color/image_raw,depth=/camera/aligned_depth/image_raw,imu=/camera/imu";
  const Outcome text = Highwall("info " + Quoted(folder / "a.bag"));
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_TRUE(Contains(text.out, "  format        ROS bag\n")) << text.out;
  EXPECT_TRUE(Contains(text.out, "  topics        " + topics + "\n")) << text.out;
  const json info = json::parse(Highwall("info --json " + Quoted(folder / "a.bag")).out);
  EXPECT_EQ(info["topics"], topics);
  EXPECT_EQ(info["frames"], testing::kSceneFrames);
  EXPECT_EQ(info["depth_factor"], 1000.0);
  EXPECT_EQ(info["imu"]["count"], testing::kSceneReadings);
  EXPECT_EQ(info["calibration"]["name"], "camera_info");
}

TEST(TopicsOfABag, TheSwitchSelectsThem) {
  const TemporaryDirectory folder;
  std::vector<WrittenMessage> messages = testing::MessagesOf({});
  for (const auto& other : testing::MessagesOf({.colour = "/other/color",
                           .depth = "/other/depth",
                           .colour_info = "/other/camera_info",
                           .imu = ""})) {
    messages.push_back(other);
  }
  const fs::path bag = folder / "a.bag";
  WriteText(bag, testing::RosbagOf(messages));
  const std::string chosen = " --topics colour=/other/color,depth=/other/depth";
  const json info = json::parse(Highwall("info --json " + Quoted(bag) + chosen).out);
  EXPECT_EQ(info["topics"], "colour=/other/color,depth=/other/depth,imu=/camera/imu");
  const Outcome convert =
      Highwall("convert " + Quoted(bag) + " " + Quoted(folder / "copy") + chosen);
  EXPECT_EQ(convert.exit_code, 0) << convert.err;
  EXPECT_TRUE(Contains(convert.err, "topics colour=/other/color,depth=/other/depth"))
      << convert.err;
  ExpectRefused(Highwall("info " + Quoted(bag) + " --topics depth=/nowhere"), 2,
                {"a.bag: has no topic /nowhere; it has /camera/color/camera_info"});
  for (const char* command :
       {"info x", "slam x --out y", "convert x y", "calibrate x", "map x --out y", "imu-noise x"}) {
    ExpectRefused(Highwall(std::string(command) + " --topics color=/a"), 1,
                  {"--topics", "'color' is none of the topics colour, depth, imu"});
  }
}

TEST(ABagWithoutCameraInfo, NeedsAConfiguration) {
  const TemporaryDirectory folder;
  WriteText(folder / "a.bag", testing::RosbagOf(testing::MessagesOf({.colour_info = ""})));
  ExpectRefused(
      Highwall("convert " + Quoted(folder / "a.bag") + " " + Quoted(folder / "copy")), 2,
      {"a.bag: the camera is unknown: the bag has no camera_info of its colour images; give "
       "--config with a file"});
}

// The noise of readings at rest, of a bag that has nothing else.
TEST(ImuNoiseOfABag, IsThatOfItsReadings) {
  const TemporaryDirectory folder;
  std::vector<WrittenMessage> messages;
  cv::RNG random(5);
  for (int i = 0; i < 20'000; ++i) {
    const auto noise = [&](double sigma) {
      return Eigen::Vector3d(random.gaussian(sigma), random.gaussian(sigma),
                             random.gaussian(sigma));
    };
    const Stamp stamp = testing::kSceneStart + i * Stamp{5'000'000};
    messages.push_back({"/imu", "sensor_msgs/Imu", stamp,
                        ImuMessage(Serialization::kCdr, stamp, "imu", noise(0.002),
                                   Eigen::Vector3d(0.0, 0.0, 9.81) + noise(0.02))});
  }
  WriteText(folder / "rest.mcap", testing::McapOf(messages, "zstd"));
  const Outcome outcome = Highwall("imu-noise --json " + Quoted(folder / "rest.mcap"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json found = json::parse(outcome.out);
  EXPECT_EQ(found["readings"], 20'000);
  EXPECT_NEAR(found["rate_hz"].get<double>(), 200.0, 1e-6);
  // 0.002 rad/s in each reading at 200 Hz; its estimate scatters by some percent.
  EXPECT_NEAR(found["gyroscope"]["white"]["value"].get<double>(), 0.002 / std::sqrt(200.0), 1.5e-5);
}

// A bag that the recorder of ROS itself wrote, where its Python module is installed.
TEST(ABagOfRosItself, IsRead) {
  const TemporaryDirectory folder;
  if (std::system("/usr/bin/python3 -c 'import rosbag, sensor_msgs' > /dev/null 2>&1") != 0) {
    GTEST_SKIP() << "python3-rosbag and python3-sensor-msgs are not installed";
  }
  WriteText(folder / "write.py", R"(
import sys, rosbag, rospy
from sensor_msgs.msg import CameraInfo, Image, Imu
for compression in ('none', 'bz2', 'lz4'):
    with rosbag.Bag('%s.bag' % compression, 'w', compression=compression) as bag:
        for i in range(5):
            t = rospy.Time(100 + i, 250)
            info = CameraInfo(width=8, height=6, distortion_model='plumb_bob', D=[0.1, 0, 0, 0, 0],
                              K=[7, 0, 3.5, 0, 7, 2.5, 0, 0, 1])
            info.header.stamp = t
            bag.write('/camera/rgb/camera_info', info, t)
            image = Image(width=8, height=6, step=24, encoding='rgb8', data=bytes([i, 20, 30] * 48))
            image.header.stamp = t
            image.header.frame_id = 'rgb'
            bag.write('/camera/rgb/image_color', image, t)
            depth = Image(width=8, height=6, step=16, encoding='16UC1', data=bytes([0, 4] * 48))
            depth.header.stamp = t
            depth.header.frame_id = 'rgb'
            bag.write('/camera/depth/image', depth, t)
            imu = Imu()
            imu.header.stamp = t
            imu.linear_acceleration.z = 9.81
            imu.angular_velocity.x = i
            bag.write('/imu', imu, t)
)");
  const Outcome written = testing::RunProgram("/usr/bin/python3", "write.py", folder.path());
  ASSERT_EQ(written.exit_code, 0) << written.err;
  for (const char* name : {"none.bag", "bz2.bag", "lz4.bag"}) {
    const auto dataset = OpenDataset(folder / name);
    ASSERT_EQ(dataset->size(), 5U);
    EXPECT_EQ(dataset->stamp(2), 102'000'000'250);
    EXPECT_EQ(dataset->calibration()->sensor.camera.k1, 0.1);
    const auto image = dataset->Load(3);
    ASSERT_TRUE(image.has_value());
    EXPECT_EQ(image->bgr.at<cv::Vec3b>(2, 3), cv::Vec3b(30, 20, 3));
    EXPECT_FLOAT_EQ(image->depth.at<float>(2, 3), 1.024F);
    const ImuRecording imu = dataset->ReadImu({0, 1});
    ASSERT_EQ(imu.samples.size(), 5U);
    EXPECT_EQ(imu.samples[4].gyroscope.x(), 4.0);
    EXPECT_EQ(imu.samples[4].accelerometer.z(), 9.81);
  }
}

}  // namespace
}  // namespace highwall::apps::bag_test
