#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>

// Messages of ROS, written as ROS 1 and ROS 2 do.
namespace highwall::testing {

enum class Serialization { kRos1, kCdr, kBigEndianCdr };

// A message in a bag. type: as in ROS 1.
struct WrittenMessage {
  std::string topic, type;
  Stamp recorded = 0;
  std::string bytes;
};

class MessageWriter {
 public:
  explicit MessageWriter(Serialization serialization) : serialization_(serialization) {
    if (serialization_ == Serialization::kRos1) return;
    bytes_ = std::string{'\0', is_big_endian() ? '\0' : '\1', '\0', '\0'};
  }

  template <class T>
  void Number(T value) {
    if (serialization_ != Serialization::kRos1) {
      while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_ += '\0';
    }
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    if (is_big_endian()) std::reverse(raw.begin(), raw.end());
    bytes_.append(raw.data(), raw.size());
  }
  void Text(const std::string& text) {
    const bool ends = serialization_ != Serialization::kRos1;
    Number(static_cast<std::uint32_t>(text.size() + (ends ? 1 : 0)));
    bytes_ += text;
    if (ends) bytes_ += '\0';
  }
  void Bytes(const std::string& bytes) {
    Number(static_cast<std::uint32_t>(bytes.size()));
    bytes_ += bytes;
  }
  void Vector(const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) Number(v(i));
  }
  void Header(Stamp stamp, const std::string& frame) {
    if (serialization_ == Serialization::kRos1) Number(std::uint32_t{7});
    Number(static_cast<std::uint32_t>(stamp / 1'000'000'000));
    Number(static_cast<std::uint32_t>(stamp % 1'000'000'000));
    Text(frame);
  }
  void Zeros(int count) {
    for (int i = 0; i < count; ++i) Number(0.0);
  }

  const std::string& bytes() const { return bytes_; }

 private:
  bool is_big_endian() const { return serialization_ == Serialization::kBigEndianCdr; }

  Serialization serialization_;
  std::string bytes_;
};

// padding: bytes behind each row.
inline std::string ImageMessage(Serialization how, Stamp stamp, const std::string& frame,
                                const cv::Mat& image, const std::string& encoding, int padding = 0,
                                bool is_big_endian = false) {
  MessageWriter writer(how);
  writer.Header(stamp, frame);
  writer.Number(static_cast<std::uint32_t>(image.rows));
  writer.Number(static_cast<std::uint32_t>(image.cols));
  writer.Text(encoding);
  writer.Number(static_cast<std::uint8_t>(is_big_endian ? 1 : 0));
  const std::size_t row = static_cast<std::size_t>(image.cols) * image.elemSize();
  writer.Number(static_cast<std::uint32_t>(row + static_cast<std::size_t>(padding)));
  std::string data;
  for (int v = 0; v < image.rows; ++v) {
    data.append(image.ptr<char>(v), row);
    data.append(static_cast<std::size_t>(padding), '\x55');
  }
  writer.Bytes(data);
  return writer.bytes();
}

inline std::string CompressedImageMessage(Serialization how, Stamp stamp, const std::string& frame,
                                          const std::string& format, const std::string& file) {
  MessageWriter writer(how);
  writer.Header(stamp, frame);
  writer.Text(format);
  writer.Bytes(file);
  return writer.bytes();
}

inline std::string CameraInfoMessage(Serialization how, const std::string& frame,
                                     const PinholeCamera& camera,
                                     const std::string& model = "plumb_bob") {
  MessageWriter writer(how);
  writer.Header(1'000'000'000, frame);
  writer.Number(static_cast<std::uint32_t>(camera.height));
  writer.Number(static_cast<std::uint32_t>(camera.width));
  writer.Text(model);
  const std::vector<double> D = model == "equidistant"
                                    ? std::vector{camera.k1, camera.k2, camera.k3, camera.k4}
                                    : std::vector{camera.k1, camera.k2, camera.p1, camera.p2,
                                                  camera.k3, camera.k4, camera.k5, camera.k6};
  writer.Number(static_cast<std::uint32_t>(D.size()));
  for (const double d : D) writer.Number(d);
  for (const double k : {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0}) {
    writer.Number(k);
  }
  for (const double r : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) writer.Number(r);
  for (const double p : {camera.fx + 1.0, 0.0, camera.cx, 0.0, 0.0, camera.fy + 1.0, camera.cy, 0.0,
                         0.0, 0.0, 1.0, 0.0}) {
    writer.Number(p);
  }
  for (int i = 0; i < 6; ++i) writer.Number(std::uint32_t{0});  // binning, region
  writer.Number(std::uint8_t{0});
  return writer.bytes();
}

inline std::string ImuMessage(Serialization how, Stamp stamp, const std::string& frame,
                              const Eigen::Vector3d& gyroscope,
                              const Eigen::Vector3d& accelerometer) {
  MessageWriter writer(how);
  writer.Header(stamp, frame);
  writer.Zeros(4 + 9);
  writer.Vector(gyroscope);
  writer.Zeros(9);
  writer.Vector(accelerometer);
  writer.Zeros(9);
  return writer.bytes();
}

inline void WriteTransform(const Pose& T, MessageWriter* writer) {
  writer->Vector(T.p());
  for (const double q : {T.q().x(), T.q().y(), T.q().z(), T.q().w()}) writer->Number(q);
}

struct WrittenTransform {
  std::string frame, child;
  Pose pose;
};

inline std::string TransformsMessage(Serialization how,
                                     const std::vector<WrittenTransform>& transforms) {
  MessageWriter writer(how);
  writer.Number(static_cast<std::uint32_t>(transforms.size()));
  for (const auto& [frame, child, pose] : transforms) {
    writer.Header(1'000'000'000, frame);
    writer.Text(child);
    WriteTransform(pose, &writer);
  }
  return writer.bytes();
}

}  // namespace highwall::testing
