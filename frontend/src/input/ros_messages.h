#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

#include "input/message_reader.h"

// Messages of ROS as far as they are used, read from their bytes. Each function throws IoError if
// the message ends early.
namespace highwall {

struct RosHeader {
  Stamp stamp = 0;
  std::string frame;  // without the leading "/" of old bags
};

// sensor_msgs/Image. data: of the message.
struct RosImage {
  RosHeader header;
  std::uint32_t height = 0, width = 0, step = 0;  // [px], [px] and [byte] of a row
  std::string encoding;
  bool is_big_endian = false;
  ByteSpan data;
};

// sensor_msgs/CompressedImage. data: of the message.
struct RosCompressedImage {
  RosHeader header;
  std::string format;
  ByteSpan data;
};

// sensor_msgs/CameraInfo.
struct RosCameraInfo {
  RosHeader header;
  std::uint32_t height = 0, width = 0;
  std::string model;
  std::vector<double> D;
  std::array<double, 9> K{};
  std::array<double, 12> P{};
};

// sensor_msgs/Imu.
struct RosImu {
  RosHeader header;
  Eigen::Vector3d gyroscope = Eigen::Vector3d::Zero();      // [rad/s]
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  // [m/s^2]
};

// geometry_msgs/TransformStamped: T_frame_child.
struct RosTransform {
  std::string frame, child;
  Pose pose;
};

RosHeader ReadRosHeader(MessageReader* reader);
RosImage ReadRosImage(MessageReader* reader);
RosCompressedImage ReadRosCompressedImage(MessageReader* reader);
RosCameraInfo ReadRosCameraInfo(MessageReader* reader);
RosImu ReadRosImu(MessageReader* reader);
// geometry_msgs/Transform; nothing if it is none, as of a quaternion of zeros.
std::optional<Pose> ReadRosTransform(MessageReader* reader);
// tf2_msgs/TFMessage, without those that are none.
std::vector<RosTransform> ReadRosTransforms(MessageReader* reader);

}  // namespace highwall
