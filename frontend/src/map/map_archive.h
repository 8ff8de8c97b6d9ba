#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <type_traits>

#include <Eigen/Core>

#include <highwall/core/error.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/map/map_ids.h>

// Encoding of the content of a map file: docs/map_file.md.
namespace highwall {

// Appends values to the content of a file.
class MapWriter {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    Bytes(&value, sizeof(T));
  }
  void Bytes(const void* data, std::size_t size) {
    content_.append(static_cast<const char*>(data), size);
  }
  const std::string& content() const { return content_; }

 private:
  std::string content_;
};

// Reads values from the content of a file, in the same order.
class MapReader {
 public:
  MapReader(const std::filesystem::path& path, const char* data, std::size_t size)
      : path_(path), data_(data), end_(data + size) {}

  template <class T>
  void operator()(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    Bytes(&value, sizeof(T));
  }
  void operator()(bool& value) {
    std::uint8_t byte = 0;
    Bytes(&byte, 1);
    Require(byte <= 1, "a yes or no is neither");
    value = byte == 1;
  }
  template <class Tag>
  void operator()(Id<Tag>& id) {
    std::int32_t number = 0;
    (*this)(number);
    id = Id<Tag>(number);
  }
  void Bytes(void* data, std::size_t size) {
    Require(size <= static_cast<std::size_t>(end_ - data_), "a part of it is missing");
    std::memcpy(data, data_, size);
    data_ += size;
  }
  std::string String() {
    std::string text(Count(1), '\0');
    Bytes(text.data(), text.size());
    return text;
  }
  // Reads the number of elements that take at least `bytes` each.
  std::uint32_t Count(std::size_t bytes) {
    std::uint32_t count = 0;
    (*this)(count);
    Require(count <= static_cast<std::size_t>(end_ - data_) / bytes, "a count is beyond its end");
    return count;
  }
  void RequireEnd() const { Require(data_ == end_, "there is more than was counted"); }
  void Require(bool condition, const char* what) const {
    if (!condition) throw IoError(path_, std::string("is damaged: ") + what);
  }

 private:
  const std::filesystem::path& path_;
  const char* data_;
  const char* end_;
};

// Bounds of plausible values, so that a loaded map can be used: beyond any image and any position
// on Earth [px, m], while squares and products remain finite.
inline constexpr double kLargest = 1e9, kSmallest = 1e-9;
inline constexpr double kUnitRounding = 1e-6;  // of unit vectors

template <class T>
bool IsBetween(T low, T value, T high) {
  return low <= value && value <= high;
}

template <class Matrix>
bool IsBounded(const Matrix& matrix) {
  return (matrix.array().abs() <= static_cast<typename Matrix::Scalar>(kLargest)).all();
}

// Reads or writes the entries of a matrix.
template <class Archive, class Matrix>
void Doubles(Archive& archive, Matrix& matrix) {
  archive.Bytes(matrix.data(), sizeof(*matrix.data()) * static_cast<std::size_t>(matrix.size()));
}

inline void WritePose(MapWriter& writer, const Pose& pose) {
  writer.Bytes(pose.data(), sizeof(double) * Pose::kSize);
}

// Reads the pose unchanged; its quaternion may deviate from unit length by rounding. what: the
// message.
inline Pose ReadPose(MapReader& reader, const char* what) {
  std::array<double, Pose::kSize> block;
  reader.Bytes(block.data(), sizeof(block));
  const Eigen::Map<const Eigen::Vector3d> p(block.data());
  const Eigen::Map<const Eigen::Vector4d> q(block.data() + 3);
  reader.Require(IsBounded(p) && std::abs(q.norm() - 1.0) <= kUnitRounding, what);
  return Pose::FromBlock(block.data());
}

}  // namespace highwall
