#include "input/bag_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <highwall/core/camera.h>
#include <highwall/core/error.h>
#include <highwall/frontend/input/sensor_profile.h>

#include "input/bag_first_message.h"
#include "input/colour_to_depth.h"
#include "input/frame_tree.h"
#include "input/lens_coefficients.h"
#include "input/message_reader.h"
#include "input/ros_messages.h"

namespace highwall {
namespace {

constexpr double kMillimetresOfBag = 1000.0;  // in a metre

// A camera as a topic states it.
struct BagCamera {
  std::string topic;
  PinholeCamera camera;
};

// Calls read(reader) for the first message of a topic that is not damaged.
template <class Read>
auto ReadFirst(const BagFile& bag, std::uint32_t topic, const Read& read) {
  return ReadFirstMessage(bag, topic, [&](const BagMessage& message) {
    const std::vector<std::uint8_t> bytes = bag.Read(message);
    const std::string name = bag.NameOf(message);
    MessageReader reader(bag.path(), name, bag.topics()[topic].encoding, bytes);
    return read(&reader);
  });
}

bool IsCameraInfo(const BagTopic& topic) {
  return topic.type == "sensor_msgs/CameraInfo" && topic.messages > 0;
}

std::string FolderOf(const std::string& topic) {
  return topic.substr(0, topic.rfind('/') == std::string::npos ? 0 : topic.rfind('/'));
}

// Returns the names that the camera_info of an image topic may have.
std::vector<std::string> CameraInfoNames(const std::string& image) {
  const std::string base = WithoutTransport(image);
  std::vector<std::string> names{FolderOf(base) + "/camera_info", base + "/camera_info"};
  constexpr std::string_view kStreamData = "/image/data";  // of the SDK of RealSense
  if (base.ends_with(kStreamData)) {
    names.push_back(base.substr(0, base.size() - kStreamData.size()) + "/info/camera_info");
  }
  return names;
}

std::optional<std::uint32_t> FindCameraInfo(const BagFile& bag, const BagImageTopic& image) {
  const std::vector<BagTopic>& topics = bag.topics();
  for (const std::string& name : CameraInfoNames(topics[image.topic].name)) {
    for (std::uint32_t i = 0; i < topics.size(); ++i) {
      if (topics[i].name == name && IsCameraInfo(topics[i])) return i;
    }
  }
  for (std::uint32_t i = 0; i < topics.size(); ++i) {
    if (!IsCameraInfo(topics[i]) || image.first.frame.empty()) continue;
    const RosCameraInfo info = ReadFirst(bag, i, ReadRosCameraInfo);
    if (info.header.frame == image.first.frame) return i;
  }
  return std::nullopt;
}

// Returns the camera of images of this size, which the topic may state in another one.
PinholeCamera CameraOfInfo(const BagFile& bag, const std::string& topic, const RosCameraInfo& info,
                           bool is_rectified, const cv::Size& size, BagCalibration* result) {
  const bool by_projection = is_rectified && info.P[0] > 0.0;
  PinholeCamera camera{.width = static_cast<int>(std::min(info.width, 1U << 20)),
                       .height = static_cast<int>(std::min(info.height, 1U << 20)),
                       .fx = by_projection ? info.P[0] : info.K[0],
                       .fy = by_projection ? info.P[5] : info.K[4],
                       .cx = by_projection ? info.P[2] : info.K[2],
                       .cy = by_projection ? info.P[6] : info.K[5]};
  if (!by_projection && !SetLens(info.model, info.D, &camera)) {
    result->warnings.push_back(bag.path().string() + ": " + topic + " has the lens model " +
                               info.model + ", which is not known: its coefficients are left out");
  }
  if (!by_projection && HasUnknownCoefficients(info.D)) {
    result->warnings.push_back(bag.path().string() + ": " + topic + " has " +
                               std::to_string(info.D.size()) +
                               " coefficients of its lens, of which the first 8 are used");
  }
  try {
    RgbdSensor{.camera = camera}.Validate();
  } catch (const InvalidArgument& error) {  // the file's fault, which IoError reports
    throw IoError(bag.path(), topic + " states no camera: " + error.what());
  }
  if (camera.width == size.width && camera.height == size.height) return camera;
  const double shape = static_cast<double>(camera.width) * size.height /
                       (static_cast<double>(camera.height) * size.width);
  if (std::abs(shape - 1.0) > 0.02) {
    throw IoError(bag.path(), topic + " is for images of " + std::to_string(camera.width) + " x " +
                                  std::to_string(camera.height) + ", but they are " +
                                  std::to_string(size.width) + " x " + std::to_string(size.height));
  }
  return ResizedCamera(camera, size);
}

std::optional<BagCamera> ReadBagCamera(const BagFile& bag, const BagImageTopic& image,
                                       const cv::Size& size, BagCalibration* result) {
  const std::optional<std::uint32_t> topic = FindCameraInfo(bag, image);
  if (!topic) return std::nullopt;
  const RosCameraInfo info = ReadFirst(bag, *topic, ReadRosCameraInfo);
  if (info.K[0] == 0.0 && info.P[0] == 0.0) return std::nullopt;  // how ROS marks no calibration
  const std::string base = WithoutTransport(bag.topics()[image.topic].name);
  const bool is_rectified = base.substr(FolderOf(base).size()).find("rect") != std::string::npos;
  const std::string& name = bag.topics()[*topic].name;
  return BagCamera{name, CameraOfInfo(bag, name, info, is_rectified, size, result)};
}

// Returns the profile of the RealSense whose SDK recorded the bag: the topic /device_0/info has
// "Name" and "Intel RealSense D435I". Null if there is none.
const SensorProfile* FindDevice(const BagFile& bag) {
  for (const BagMessage& message : bag.messages()) {
    const BagTopic& topic = bag.topics()[message.topic];
    if (topic.type != "diagnostic_msgs/KeyValue" || !topic.name.starts_with("/device_") ||
        !topic.name.ends_with("/info")) {
      continue;
    }
    const std::vector<std::uint8_t> bytes = bag.Read(message);
    const std::string name = bag.NameOf(message);
    MessageReader reader(bag.path(), name, topic.encoding, bytes);
    const std::string key = reader.Text(), value = reader.Text();
    if (key != "Name") continue;
    for (const auto& [model, profile] :
         {std::pair("D415", "d415"), {"D435", "d435"}, {"D455", "d455"}, {"L515", "l515"}}) {
      if (value.find(model) != std::string::npos) return FindSensorProfile(profile);
    }
  }
  return nullptr;
}

bool IsOneView(const PinholeCamera& a, const PinholeCamera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy;
}

bool IsIdentity(const Pose& T) {
  constexpr double kTolerance = 1e-6;  // [m], [rad]
  return T.p().norm() < kTolerance && T.q().vec().norm() < 0.5 * kTolerance;
}

std::string FrameOfImages(const BagFile& bag, const BagImageTopic& image) {
  return FrameOf(bag, bag.topics()[image.topic].name, image.first.frame);
}

// States the depth camera of depth that is not registered, if the bag does.
void AddDepthCamera(const BagFile& bag, const BagImageTopics& images, const FrameTree& tree,
                    const cv::Size& size, BagCalibration* result) {
  RgbdSensor& sensor = result->calibration->sensor;
  const std::optional<BagCamera> depth = ReadBagCamera(bag, images.depth, size, result);
  if (!depth) return;
  const std::string from = FrameOfImages(bag, images.depth), to = FrameOfImages(bag, images.colour);
  const std::optional<Pose> T_CD = tree.Find(to, from);
  // Two cameras may share one nominal calibration: only their poses tell.
  if (IsOneView(depth->camera, sensor.camera) && (!T_CD || IsIdentity(*T_CD))) return;
  if (T_CD) {
    sensor.depth_camera = DepthCameraCalibration{depth->camera, *T_CD};
    return;
  }
  result->warnings.push_back(
      bag.path().string() + ": depth has a camera of its own (" + depth->topic +
      "), and neither /tf_static nor /tf connects its frame '" + from + "' to that of colour, '" +
      to + "': state depth_camera in a file for --config, or record depth aligned to colour");
}

void AddImu(const BagFile& bag, const BagImageTopics& images, const BagImuTopics& imu,
            const FrameTree& tree, BagCalibration* result) {
  const std::string name = bag.topics()[imu.gyroscope].name;
  const RosImu first = ReadFirst(bag, imu.gyroscope, ReadRosImu);
  const std::optional<Pose> T_BC =
      tree.Find(FrameOf(bag, name, first.header.frame), FrameOfImages(bag, images.colour));
  if (T_BC) result->calibration->imu = ImuCalibration{.T_BC = *T_BC};
}

}  // namespace

BagCalibration ReadBagCalibration(const BagFile& bag, const BagImageTopics& images,
                                  const std::optional<BagImuTopics>& imu, const cv::Size& colour,
                                  const cv::Size& depth) {
  BagCalibration result;
  result.is_registered = images.is_registered;
  const std::optional<BagCamera> camera = ReadBagCamera(bag, images.colour, colour, &result);
  if (!camera) return result;
  RgbdSensor& sensor = result.calibration.emplace().sensor;
  if (const SensorProfile* const device = FindDevice(bag)) {
    sensor = device->SensorFor(camera->camera);
  }
  sensor.camera = camera->camera;
  sensor.depth_factor = DepthFactorOf(bag, images.depth);
  const FrameTree tree = ReadFrameTree(bag);
  if (!images.is_registered) AddDepthCamera(bag, images, tree, depth, &result);
  if (imu) AddImu(bag, images, *imu, tree, &result);
  return result;
}

double DepthFactorOf(const BagFile& bag, const BagImageTopic& depth) {
  if (depth.first.in_metres) return 1.0;
  for (std::uint32_t i = 0; i < bag.topics().size(); ++i) {
    const BagTopic& topic = bag.topics()[i];
    const bool is_unit = topic.name.ends_with("/option/Depth_Units/value") ||
                         topic.name.ends_with("/option/Depth Units/value");
    if (!is_unit || topic.type != "std_msgs/Float32" || topic.messages == 0) continue;
    const auto unit = static_cast<double>(
        ReadFirst(bag, i, [](MessageReader* reader) { return reader->Number<float>(); }));
    // Rounded: the float 0.001 is not a thousandth.
    if (unit > 1e-6 && unit < 1.0) return std::round(1e3 / unit) / 1e3;
  }
  return kMillimetresOfBag;
}

}  // namespace highwall
