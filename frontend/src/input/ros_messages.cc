#include "input/ros_messages.h"

#include <cstddef>
#include <utility>

#include <highwall/core/error.h>

namespace highwall {
namespace {

std::string FrameText(MessageReader* reader) {
  std::string frame = reader->Text();
  if (frame.starts_with('/')) frame.erase(0, 1);
  return frame;
}

Eigen::Vector3d ReadVector(MessageReader* reader) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) v(i) = reader->Number<double>();
  return v;
}

template <std::size_t kSize>
std::array<double, kSize> ReadNumbers(MessageReader* reader) {
  std::array<double, kSize> numbers{};
  for (double& number : numbers) number = reader->Number<double>();
  return numbers;
}

}  // namespace

RosHeader ReadRosHeader(MessageReader* reader) {
  if (!reader->is_cdr()) reader->Number<std::uint32_t>();  // its sequence number
  RosHeader header;
  header.stamp = reader->Time();
  header.frame = FrameText(reader);
  return header;
}

RosImage ReadRosImage(MessageReader* reader) {
  RosImage image;
  image.header = ReadRosHeader(reader);
  image.height = reader->Number<std::uint32_t>();
  image.width = reader->Number<std::uint32_t>();
  image.encoding = reader->Text();
  image.is_big_endian = reader->Flag();
  image.step = reader->Number<std::uint32_t>();
  image.data = reader->Bytes();
  return image;
}

RosCompressedImage ReadRosCompressedImage(MessageReader* reader) {
  RosCompressedImage image;
  image.header = ReadRosHeader(reader);
  image.format = reader->Text();
  image.data = reader->Bytes();
  return image;
}

RosCameraInfo ReadRosCameraInfo(MessageReader* reader) {
  RosCameraInfo info;
  info.header = ReadRosHeader(reader);
  info.height = reader->Number<std::uint32_t>();
  info.width = reader->Number<std::uint32_t>();
  info.model = reader->Text();
  info.D.resize(reader->Count(sizeof(double)));
  for (double& d : info.D) d = reader->Number<double>();
  info.K = ReadNumbers<9>(reader);
  reader->SkipNumbers(9, sizeof(double));  // R
  info.P = ReadNumbers<12>(reader);
  return info;
}

RosImu ReadRosImu(MessageReader* reader) {
  RosImu imu;
  imu.header = ReadRosHeader(reader);
  constexpr std::size_t kQuaternion = 4, kCovariance = 9;
  reader->SkipNumbers(kQuaternion + kCovariance, sizeof(double));
  imu.gyroscope = ReadVector(reader);
  reader->SkipNumbers(kCovariance, sizeof(double));
  imu.accelerometer = ReadVector(reader);
  return imu;
}

std::optional<Pose> ReadRosTransform(MessageReader* reader) {
  const Eigen::Vector3d p = ReadVector(reader);
  const std::array<double, 4> q = ReadNumbers<4>(reader);
  try {
    return Pose(Eigen::Quaterniond(q[3], q[0], q[1], q[2]), p);
  } catch (const InvalidArgument&) {
    return std::nullopt;
  }
}

std::vector<RosTransform> ReadRosTransforms(MessageReader* reader) {
  constexpr std::size_t kSmallest = 72;  // [byte] of a transform without names
  std::vector<RosTransform> transforms;
  for (std::size_t left = reader->Count(kSmallest); left > 0; --left) {
    std::string frame = ReadRosHeader(reader).frame, child = FrameText(reader);
    const std::optional<Pose> pose = ReadRosTransform(reader);
    if (pose) transforms.push_back({std::move(frame), std::move(child), *pose});
  }
  return transforms;
}

}  // namespace highwall
