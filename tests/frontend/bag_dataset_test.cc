// Bags as recordings: frames, calibration, readings, stamps.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/bag_imu.h>
#include <highwall/frontend/input/open_dataset.h>
#include <highwall/frontend/input/sensor_profile.h>

#include "input/bag_readings.h"
#include "support/bag_files.h"
#include "support/message_of.h"
#include "support/recorded_scene.h"
#include "support/temporary_directory.h"

namespace highwall::bag_dataset_test {
namespace {

namespace fs = std::filesystem;
using testing::ExpectError;
using testing::kSceneFrames;
using testing::MessagesOf;
using testing::RecordedScene;
using testing::SceneStamp;
using testing::Serialization;
using testing::TemporaryDirectory;
using testing::WriteText;
using testing::WrittenMessage;

class BagDatasetTest : public ::testing::Test {
 protected:
  fs::path path() const { return folder_ / "a.bag"; }
  std::unique_ptr<Dataset> Open(const std::vector<WrittenMessage>& messages,
                                const std::optional<RgbdSensor>& sensor = std::nullopt,
                                const DatasetOptions& options = {}) const {
    WriteText(path(), testing::RosbagOf(messages, "lz4"));
    return OpenDataset(path(), sensor, options);
  }

  TemporaryDirectory folder_;
};

void ExpectScene(const Dataset& dataset) {
  ASSERT_EQ(dataset.size(), std::size_t{kSceneFrames});
  for (int i = 0; i < kSceneFrames; ++i) {
    const auto index = static_cast<std::size_t>(i);
    EXPECT_EQ(dataset.stamp(index), SceneStamp(i));
    EXPECT_EQ(dataset.depth_stamp(index), SceneStamp(i) + 2'000'000);
    const std::optional<RgbdImage> image = dataset.Load(index);
    ASSERT_TRUE(image.has_value()) << dataset.problems().at(0).what;
    EXPECT_EQ(cv::norm(image->bgr, testing::SceneColour(i), cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::norm(image->depth, MetricDepth(testing::SceneDepth(i), 1000.0), cv::NORM_INF),
              0.0);
  }
  ASSERT_NE(dataset.calibration(), nullptr);
  const RgbdSensor& sensor = dataset.calibration()->sensor;
  EXPECT_EQ(sensor.camera.fx, 60.0);
  EXPECT_EQ(sensor.camera.fy, 61.0);
  EXPECT_EQ(sensor.camera.k1, 0.01);
  EXPECT_EQ(sensor.depth_factor, 1000.0);
  EXPECT_TRUE(dataset.is_registered());
  EXPECT_TRUE(dataset.warnings().empty()) << dataset.warnings().front();
  const ImuRecording imu = dataset.ReadImu({SceneStamp(0), SceneStamp(kSceneFrames - 1)});
  ASSERT_EQ(imu.samples.size(), std::size_t{testing::kSceneReadings});
  for (int i = 0; i < testing::kSceneReadings; ++i) {
    const ImuSample& sample = imu.samples[static_cast<std::size_t>(i)];
    EXPECT_EQ(sample.stamp, testing::ReadingStamp(i));
    EXPECT_EQ(sample.gyroscope, testing::SceneRate(i));
    EXPECT_EQ(sample.accelerometer, testing::SceneForce(i));
  }
}

TEST_F(BagDatasetTest, EveryContainerAndSerializationGivesTheSame) {
  ExpectScene(*Open(MessagesOf({})));
  for (const Serialization how : {Serialization::kCdr, Serialization::kBigEndianCdr}) {
    const std::vector<WrittenMessage> messages = MessagesOf({.how = how});
    for (const char* compression : {"none", "lz4", "zstd"}) {
      WriteText(folder_ / "a.mcap", testing::McapOf(messages, compression));
      ExpectScene(*OpenDataset(folder_ / "a.mcap"));
    }
    const fs::path folder = folder_ / ("ros2_" + std::to_string(static_cast<int>(how)));
    fs::create_directory(folder);
    WriteText(folder / "metadata.yaml", "rosbag2_bagfile_information:\n");
    testing::WriteSqliteBag(folder / "a_0.db3", messages);
    ExpectScene(*OpenDataset(folder));
    ExpectScene(*OpenDataset(folder / "a_0.db3"));
  }
}

TEST_F(BagDatasetTest, TopicsAreGuessedUnlessTheyAreGiven) {
  const auto guessed = Open(MessagesOf({}));
  EXPECT_EQ(ToText(guessed->topics()),
            "colour=/camera/color/image_raw,depth=/camera/aligned_depth/image_raw,imu=/camera/imu");
  std::vector<WrittenMessage> messages = MessagesOf({.colour = "/x", .depth = "/y", .imu = "/z"});
  for (const WrittenMessage& other : MessagesOf({})) messages.push_back(other);
  const BagTopics topics = ReadBagTopics("colour=/x,depth=/y,imu=/z");
  EXPECT_EQ(Open(messages, std::nullopt, {.topics = topics})->topics(), topics);
}

TEST_F(BagDatasetTest, AConfigurationReplacesTheStatedCameraAndFactor) {
  RgbdSensor sensor;
  sensor.camera = RecordedScene().camera;
  sensor.camera.fx = 70.0;
  sensor.depth_factor = 500.0;
  const auto dataset = Open(MessagesOf({}), sensor);
  EXPECT_EQ(
      cv::norm(dataset->Load(0)->depth, MetricDepth(testing::SceneDepth(0), 500.0), cv::NORM_INF),
      0.0);
  sensor.camera.width = 65;
  EXPECT_FALSE(Open(MessagesOf({}), sensor)->Load(0).has_value());
}

TEST_F(BagDatasetTest, WithoutStampsInTheHeadersThoseOfTheRecordingAreUsed) {
  const auto dataset = Open(MessagesOf({.has_stamps = false}));
  ASSERT_EQ(dataset->warnings().size(), 1U);
  EXPECT_NE(dataset->warnings()[0].find("the times of recording are used"), std::string::npos);
  EXPECT_EQ(dataset->stamp(1), SceneStamp(1) + RecordedScene().recorded_later);
  EXPECT_EQ(dataset->ReadImu({0, 1}).samples[0].stamp,
            testing::ReadingStamp(0) + RecordedScene().recorded_later);
}

// The k-th message of a topic.
WrittenMessage& MessageOfTopic(std::vector<WrittenMessage>* messages, const std::string& topic,
                               int k) {
  for (WrittenMessage& message : *messages) {
    if (message.topic == topic && k-- == 0) return message;
  }
  throw InvalidArgument("no such message");
}

// A driver may publish a first message before it has a time.
TEST_F(BagDatasetTest, AFewMessagesWithoutAStampAreLeftOut) {
  const RecordedScene scene;
  std::vector<WrittenMessage> messages = MessagesOf(scene);
  for (const auto& [topic, k] : {std::pair(scene.colour, 0),
                                 {scene.depth, 0},

                                 {scene.imu, 0},
                                 {scene.imu, 7}}) {
    constexpr std::size_t kStamp = 4, kSize = 8;
    MessageOfTopic(&messages, topic, k).bytes.replace(kStamp, kSize, kSize, '\0');
  }
  MessageOfTopic(&messages, scene.depth, 5).bytes.resize(11);  // ends within its stamp
  const auto dataset = Open(messages);
  ASSERT_EQ(dataset->warnings().size(), 1U);
  EXPECT_NE(dataset->warnings()[0].find("a.bag: 3 images have no stamp and are not used"),
            std::string::npos);
  ASSERT_EQ(dataset->size(), 4U);
  EXPECT_EQ(dataset->stamp(0), SceneStamp(1));
  EXPECT_EQ(dataset->stamp(3), SceneStamp(4));
  const ImuRecording imu = dataset->ReadImu({0, 1});
  EXPECT_EQ(imu.samples.size(), std::size_t{testing::kSceneReadings - 2});
  EXPECT_EQ(imu.samples[0].stamp, testing::ReadingStamp(1));
  EXPECT_EQ(imu.warning, path().string() + ": readings of the IMU are not used: 2 without a stamp");
  EXPECT_EQ(ReadBagImu(path()).samples[0].stamp, testing::ReadingStamp(1));
}

TEST_F(BagDatasetTest, WithoutAnyTimesItIsRefused) {
  std::vector<WrittenMessage> messages =
      MessagesOf({.how = Serialization::kCdr, .has_stamps = false});
  for (WrittenMessage& message : messages) message.recorded = -message.recorded;
  testing::WriteSqliteBag(folder_ / "a.db3", messages);
  ExpectError<IoError>("a.db3: no image of /camera/color/image_raw has a stamp, and none a time",
                       [&] { OpenDataset(folder_ / "a.db3"); });
}

TEST_F(BagDatasetTest, AnAccelerometerWithoutStampsMakesTheTimesOfRecordingBeUsed) {
  std::vector<WrittenMessage> messages = MessagesOf({.imu = "/gyro/sample"});
  for (const WrittenMessage& message : MessagesOf({.imu = "/accel/sample", .has_stamps = false})) {
    if (message.topic == "/accel/sample") messages.push_back(message);
  }
  const Stamp first = testing::ReadingStamp(0) + RecordedScene().recorded_later;
  const auto dataset = Open(messages);
  ASSERT_EQ(dataset->warnings().size(), 1U);
  EXPECT_NE(dataset->warnings()[0].find("the times of recording are used"), std::string::npos);
  EXPECT_EQ(dataset->ReadImu({0, 1}).samples.at(0).stamp, first);
  EXPECT_EQ(ReadBagImu(path()).samples.at(0).stamp, first);
}

TEST_F(BagDatasetTest, ReadingsThatAreDamagedAreLeftOutAndNamed) {
  const RecordedScene scene;
  std::vector<WrittenMessage> messages = MessagesOf(scene);
  for (const int k : {3, 60}) MessageOfTopic(&messages, scene.imu, k).bytes.resize(100);
  const ImuRecording imu = Open(messages)->ReadImu({0, 1});
  EXPECT_EQ(imu.samples.size(), std::size_t{testing::kSceneReadings - 2});
  EXPECT_EQ(imu.warning, path().string() +
                             ": readings of the IMU are not used: 2 damaged (the "
                             "first: " +
                             path().string() +
                             ": the message of /camera/imu recorded at "
                             "1699999999.970000 s ends early)");
  for (int k = 1; k < testing::kSceneReadings; ++k) {
    MessageOfTopic(&messages, scene.imu, k).bytes.resize(100);
  }
  MessageOfTopic(&messages, scene.imu, 0).bytes.replace(4, 8, 8, '\0');
  ExpectError<IoError>(path().string() +
                           ": its IMU has no reading that can be used; not used are "
                           "120 damaged (the first: ",
                       [&] {
                         Open(messages)->ReadImu({0, 1});
                       });
}

TEST_F(BagDatasetTest, DepthInMetresIsTakenAsItIs) {
  std::vector<WrittenMessage> messages = MessagesOf({});
  int frame = 0;
  for (WrittenMessage& message : messages) {
    if (message.topic != RecordedScene().depth) continue;
    const Stamp stamp = SceneStamp(frame) + 2'000'000;
    message.bytes = ImageMessage(Serialization::kRos1, stamp, "color_optical",
                                 MetricDepth(testing::SceneDepth(frame), 1000.0), "32FC1");
    ++frame;
  }
  RgbdSensor tum;
  tum.camera = RecordedScene().camera;
  tum.depth_factor = 5000.0;
  for (const auto& sensor : {std::optional<RgbdSensor>(), std::optional(tum)}) {
    const auto dataset = Open(messages, sensor);
    EXPECT_EQ(dataset->calibration()->sensor.depth_factor, 1.0);
    EXPECT_EQ(cv::norm(dataset->Load(2)->depth, MetricDepth(testing::SceneDepth(2), 1000.0),
                       cv::NORM_INF),
              0.0);
  }
}

// The same camera, 10 cm to the left: what it sees at z moves by fx 0.1 / z to the left in colour.
TEST_F(BagDatasetTest, DepthOfItsOwnCameraIsRegisteredByTheTransformsOfTheBag) {
  const Pose T_OD(Eigen::Quaterniond(1, 0, 0, 0), {0.0, 0.2, 0.0});
  const Pose T_OC(Eigen::Quaterniond(1, 0, 0, 0), {0.1, 0.2, 0.0});
  RecordedScene scene{.depth = "/camera/depth/image_raw", .depth_frame = "depth_optical"};
  scene.camera.k1 = 0.0;
  std::vector<WrittenMessage> messages = MessagesOf(scene);
  PinholeCamera depth = scene.camera;
  depth.fx = depth.fy = scene.camera.fy;
  messages.push_back({"/camera/depth/camera_info", "sensor_msgs/CameraInfo", testing::kSceneStart,
                      CameraInfoMessage(scene.how, "depth_optical", depth)});
  const auto transforms = [&](const std::vector<testing::WrittenTransform>& list) {
    return WrittenMessage{"/tf_static", "tf2_msgs/TFMessage", testing::kSceneStart,
                          TransformsMessage(scene.how, list)};
  };
  const Pose T_OB(Eigen::Quaterniond(0, 1, 0, 0), {0.0, 0.0, 0.3});
  std::vector<WrittenMessage> with = messages;
  with.push_back(transforms({{"base", "depth_optical", T_OD}}));
  with.push_back(transforms({{"base", "/color_optical", T_OC}, {"base", "imu_frame", T_OB}}));
  const auto dataset = Open(with);
  EXPECT_TRUE(dataset->warnings().empty());
  EXPECT_TRUE(dataset->is_registered());
  const SensorCalibration& stated = *dataset->calibration();
  ASSERT_TRUE(stated.sensor.depth_camera.has_value());
  EXPECT_TRUE(stated.sensor.depth_camera->T_CD.p().isApprox(Eigen::Vector3d(-0.1, 0.0, 0.0)));
  EXPECT_EQ(stated.sensor.depth_camera->camera.fx, depth.fx);
  ASSERT_TRUE(stated.imu.has_value());
  EXPECT_TRUE(stated.imu->T_BC.Matrix().isApprox((T_OB.Inverse() * T_OC).Matrix(), 1e-12));
  EXPECT_NEAR(stated.imu->rate, 200.0, 1e-9);
  EXPECT_EQ(dataset->Load(0)->depth.size(), cv::Size(64, 48));

  const auto without = Open(messages);
  EXPECT_FALSE(without->is_registered());
  ASSERT_EQ(without->warnings().size(), 1U);
  EXPECT_NE(without->warnings()[0].find(
                "neither /tf_static nor /tf connects its frame 'depth_optical' to that of colour, "
                "'color_optical'"),
            std::string::npos);
}

TEST_F(BagDatasetTest, ATransformThatIsNoneIsLeftOut) {
  const RecordedScene scene;
  const Pose T_OC(Eigen::Quaterniond(1, 0, 0, 0), {0.1, 0.2, 0.0});
  std::string bytes = TransformsMessage(
      scene.how, {{"base", "wheel", Pose()}, {"imu_frame", "color_optical", T_OC}});
  const std::string one = testing::LittleEndian(1.0);  // w of the first
  bytes.replace(bytes.find(one), one.size(), one.size(), '\0');
  std::vector<WrittenMessage> messages = MessagesOf(scene);
  messages.push_back({"/tf_static", "tf2_msgs/TFMessage", testing::kSceneStart, bytes});
  const auto dataset = Open(messages);
  ASSERT_TRUE(dataset->calibration()->imu.has_value());
  EXPECT_TRUE(dataset->calibration()->imu->T_BC.p().isApprox(T_OC.p(), 1e-12));
}

// As the static publishers of ROS 1 write them. The robot rests in the first half.
TEST_F(BagDatasetTest, TransformsThatNeverChangeInTfConnectWhatTfStaticDoesNot) {
  const RecordedScene scene;
  const auto shift = [](double x) { return Pose(Eigen::Quaterniond(1, 0, 0, 0), {x, 0, 0}); };
  const auto imu_from_tf = [&](const std::string& imu_parent, bool has_static) {
    std::vector<WrittenMessage> messages = MessagesOf(scene);
    const auto add = [&](const std::string& topic, int i,
                         const std::vector<testing::WrittenTransform>& transforms) {
      messages.push_back({topic, "tf2_msgs/TFMessage", testing::kSceneStart + i * 100'000,
                          TransformsMessage(scene.how, transforms)});
    };
    constexpr int kMessages = 2000;
    for (int i = 0; i < kMessages; ++i) {
      add("/tf", i, {{"odom", "base", shift(i < kMessages / 2 ? 0.0 : 0.001 * i)}});
      add("/tf", i, {{"base", "color_optical", shift(0.1)}, {imu_parent, "imu_frame", shift(0.3)}});
    }
    add("/tf", kMessages, {{"base", "wheel", Pose()}});
    messages.back().bytes.resize(20);
    if (has_static) add("/tf_static", 0, {{"imu_frame", "color_optical", shift(7.0)}});
    return Open(messages)->calibration()->imu;
  };
  EXPECT_NEAR(imu_from_tf("base", false).value().T_BC.p().x(), 0.1 - 0.3, 1e-12);
  EXPECT_NEAR(imu_from_tf("base", true).value().T_BC.p().x(), 7.0, 1e-12);
  EXPECT_FALSE(imu_from_tf("odom", false).has_value());
}

TEST_F(BagDatasetTest, TheExtrinsicsAndTheDepthUnitOfARealSenseAreUsed) {
  const std::string device = "/device_0/sensor_";
  RecordedScene scene{.colour = device + "1/Color_0/image/data",
                      .depth = device + "0/Depth_0/image/data",
                      .colour_info = device + "1/Color_0/info/camera_info",
                      .imu = "",
                      .colour_frame = "0",
                      .depth_frame = "0"};
  std::vector<WrittenMessage> messages = MessagesOf(scene);
  PinholeCamera depth = scene.camera;
  depth.fx = 55.0;
  messages.push_back({device + "0/Depth_0/info/camera_info", "sensor_msgs/CameraInfo", 1,
                      CameraInfoMessage(scene.how, "0", depth)});
  const auto transform = [&](const std::string& stream, const Pose& T) {
    testing::MessageWriter writer(scene.how);
    WriteTransform(T, &writer);
    messages.push_back({device + stream + "/tf/0", "geometry_msgs/Transform", 1, writer.bytes()});
  };
  const Pose T_C0(Eigen::Quaterniond(0.99, 0.1, 0.0, 0.0), {0.015, 0.0, 0.0});
  transform("0/Depth_0", Pose());  // the reference
  transform("1/Color_0", T_C0);
  transform("2/Gyro_0", Pose(Eigen::Quaterniond(1, 0, 0, 0), {0.0, 0.02, 0.0}));
  for (const auto& [key, value] :
       {std::pair("Serial Number", "D415"), {"Name", "Intel RealSense D435I"}}) {
    testing::MessageWriter writer(scene.how);
    writer.Text(key);
    writer.Text(value);
    messages.push_back({"/device_0/info", "diagnostic_msgs/KeyValue", 1, writer.bytes()});
  }
  testing::MessageWriter unit(scene.how);
  unit.Number(0.0001F);
  messages.push_back({device + "0/option/Depth_Units/value", "std_msgs/Float32", 1, unit.bytes()});
  for (int i = 0; i < 100; ++i) {  // two rates: 200 and 100 Hz
    const Stamp stamp = testing::ReadingStamp(i);
    messages.push_back({device + "2/Gyro_0/imu/data", "sensor_msgs/Imu", stamp,
                        ImuMessage(scene.how, stamp, "0", testing::SceneRate(i), {0, 0, 0})});
    if (i % 2 == 1) continue;
    messages.push_back({device + "2/Accel_0/imu/data", "sensor_msgs/Imu", stamp + 1,
                        ImuMessage(scene.how, stamp, "0", {0, 0, 0}, testing::SceneForce(i))});
  }
  const auto dataset = Open(messages);
  const SensorCalibration& stated = *dataset->calibration();
  EXPECT_EQ(stated.sensor.depth_factor, 10000.0);
  EXPECT_EQ(stated.sensor.min_depth, FindSensorProfile("d435")->min_depth);
  ASSERT_TRUE(stated.sensor.depth_camera.has_value());
  EXPECT_TRUE(stated.sensor.depth_camera->T_CD.Matrix().isApprox(T_C0.Matrix(), 1e-12));
  EXPECT_TRUE(
      stated.imu->T_BC.p().isApprox(Eigen::Vector3d(0.0, 0.02, 0.0) + T_C0.Inverse().p(), 1e-12));
  const ImuRecording imu = dataset->ReadImu({0, 1});
  ASSERT_EQ(imu.samples.size(), 99U);  // the last has no reading behind it
  for (int i = 0; i < 99; ++i) {
    const ImuSample& sample = imu.samples[static_cast<std::size_t>(i)];
    EXPECT_EQ(sample.gyroscope, testing::SceneRate(i));
    EXPECT_TRUE(sample.accelerometer.isApprox(testing::SceneForce(i), 1e-12));
  }
}

TEST(JoinReadings, NothingIsInterpolatedOverAGap) {
  const auto at = [](Stamp stamp, double force) {
    return ImuSample{.stamp = stamp, .accelerometer = {force, 0.0, 0.0}};
  };
  const std::vector<ImuSample> joined =
      JoinReadings({at(-1, 0), at(5'000'000, 0), at(10'000'000, 0), at(60'000'000, 0),
                    at(200'000'000, 0), at(200'000'001, 0)},
                   {at(200'000'000, 7.0), at(0, 1.0), at(10'000'000, 3.0)});
  ASSERT_EQ(joined.size(), 3U);
  EXPECT_DOUBLE_EQ(joined[0].accelerometer.x(), 2.0);
  EXPECT_DOUBLE_EQ(joined[1].accelerometer.x(), 3.0);
  EXPECT_DOUBLE_EQ(joined[2].accelerometer.x(), 7.0);
}

TEST_F(BagDatasetTest, WithoutACameraInfoThereIsNoCalibration) {
  const auto dataset = Open(MessagesOf({.colour_info = ""}));
  EXPECT_EQ(dataset->calibration(), nullptr);
  EXPECT_TRUE(dataset->Load(0).has_value());
}

TEST_F(BagDatasetTest, LensesOfEveryModelAreKnown) {
  const auto camera = [&](const std::string& model, const std::string& image = "image_raw") {
    RecordedScene scene{.colour = "/camera/color/" + image, .colour_info = ""};
    std::vector<WrittenMessage> messages = MessagesOf(scene);
    scene.camera.k4 = 0.02;
    messages.push_back({"/camera/color/camera_info", "sensor_msgs/CameraInfo", 1,
                        CameraInfoMessage(scene.how, "", scene.camera, model)});
    return Open(messages)->calibration()->sensor.camera;
  };
  EXPECT_EQ(camera("equidistant").lens, LensModel::kEquidistant);
  EXPECT_EQ(camera("equidistant").k4, 0.02);
  EXPECT_EQ(camera("rational_polynomial").k4, 0.02);
  EXPECT_EQ(camera("rational_polynomial").lens, LensModel::kRadialTangential);
  EXPECT_FALSE(camera("unknown").HasDistortion());
  EXPECT_FALSE(camera("plumb_bob", "image_rect_color").HasDistortion());
  EXPECT_EQ(camera("plumb_bob", "image_rect_color").fx, 61.0);
  EXPECT_EQ(camera("plumb_bob").fx, 60.0);
}

TEST_F(BagDatasetTest, SaysWhatIsWrongWithARecording) {
  const auto expect = [&](const RecordedScene& scene, const std::string& message,
                          const DatasetOptions& options = {}) {
    ExpectError<IoError>(path().string() + ": " + message,
                         [&] { Open(MessagesOf(scene), std::nullopt, options); });
  };
  expect({}, "has no topic /x; it has /camera/color/camera_info (sensor_msgs/CameraInfo), ",
         {.topics = {.colour = "/x"}});
  expect({},
         "no image of /camera/color/image_raw has one of /camera/aligned_depth/image_raw within "
         "0.001 s",
         {.max_stamp_difference = 0.001});
  RecordedScene other;
  other.camera.width = 100;
  expect(other, "/camera/color/camera_info is for images of 100 x 48, but they are 64 x 48");
  other.camera.fx = 1.0;
  expect(other, "/camera/color/camera_info states no camera: ");
  RgbdSensor sensor;
  sensor.camera = RecordedScene().camera;
  const auto dataset = Open(MessagesOf(other), sensor);
  ASSERT_EQ(dataset->warnings().size(), 1U);
  EXPECT_NE(dataset->warnings()[0].find("; the configuration is used alone"), std::string::npos);
  EXPECT_TRUE(dataset->Load(0).has_value());
}

// All zero, as drivers publish it.
TEST_F(BagDatasetTest, ACameraThatIsNotCalibratedStatesNothing) {
  std::vector<WrittenMessage> messages = MessagesOf({.colour_info = ""});
  testing::MessageWriter writer(Serialization::kRos1);
  writer.Header(1, "color_optical");
  writer.Number(std::uint32_t{48});
  writer.Number(std::uint32_t{64});
  writer.Text("");
  writer.Number(std::uint32_t{0});
  writer.Zeros(9 + 9 + 12);
  messages.push_back({"/camera/color/camera_info", "sensor_msgs/CameraInfo", 1, writer.bytes()});
  EXPECT_EQ(Open(messages)->calibration(), nullptr);
}

TEST_F(BagDatasetTest, AFrameThatIsDamagedIsAProblemAndNamed) {
  std::vector<WrittenMessage> messages = MessagesOf({});
  for (WrittenMessage& message : messages) {
    if (message.topic == RecordedScene().depth) message.bytes.resize(1000);
    if (message.topic == RecordedScene().depth && message.recorded > SceneStamp(2)) break;
  }
  const auto dataset = Open(messages);
  EXPECT_FALSE(dataset->Load(0).has_value());
  EXPECT_TRUE(dataset->Load(5).has_value());
  EXPECT_NE(dataset->problems().at(0).what.find(
                "a.bag: the message of /camera/aligned_depth/image_raw recorded at "),
            std::string::npos);
}

TEST_F(BagDatasetTest, AnImuAloneIsRead) {
  std::vector<WrittenMessage> messages = MessagesOf({});
  std::erase_if(messages, [](const WrittenMessage& m) { return m.type != "sensor_msgs/Imu"; });
  WriteText(path(), testing::RosbagOf(messages));
  EXPECT_EQ(ReadBagImu(path()).samples.size(), std::size_t{testing::kSceneReadings});
  ExpectError<IoError>("has no topic /x", [&] { ReadBagImu(path(), {.imu = "/x"}); });
  WriteText(path(), testing::RosbagOf(MessagesOf({.imu = ""})));
  ExpectError<IoError>("holds no readings of an IMU; it has /camera/color/camera_info",
                       [&] { ReadBagImu(path()); });
}

}  // namespace
}  // namespace highwall::bag_dataset_test
