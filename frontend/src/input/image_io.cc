#include "input/image_io.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include <highwall/core/crc32.h>
#include <highwall/core/error.h>

#include "input/jpeg_extent.h"

namespace highwall {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes ReadBytes(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw IoError(path, "cannot be read: " + error.message());
  Bytes bytes(size);
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!file) throw IoError(path, "cannot be read");
  if (bytes.empty()) throw IoError(path, "is empty");
  return bytes;
}

template <std::size_t kSize>
bool StartsWith(const Bytes& bytes, const std::array<std::uint8_t, kSize>& magic) {
  return bytes.size() >= kSize && std::equal(magic.begin(), magic.end(), bytes.begin());
}

enum class Condition { kWhole, kNoEnd, kTruncated, kDamaged };

std::uint32_t BigEndian(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24U | std::uint32_t{bytes[1]} << 16U |
         std::uint32_t{bytes[2]} << 8U | std::uint32_t{bytes[3]};
}

// Checks the chunks (length, type, data, checksum; PNG specification, section 5.3) up to IEND.
Condition ConditionOfPng(const Bytes& bytes) {
  constexpr std::size_t kSignature = 8, kOverhead = 12;
  const std::array<std::uint8_t, 4> end{'I', 'E', 'N', 'D'};
  std::size_t at = kSignature;
  while (bytes.size() - at >= kOverhead) {
    const std::size_t length = BigEndian(&bytes[at]);
    if (length > bytes.size() - at - kOverhead) return Condition::kTruncated;
    const std::uint8_t* type = &bytes[at + 4];
    const std::uint8_t* checksum = type + 4 + length;
    if (Crc32(std::as_bytes(std::span(type, checksum))) != BigEndian(checksum)) {
      return Condition::kDamaged;
    }
    if (std::equal(end.begin(), end.end(), type)) return Condition::kWhole;
    at += length + kOverhead;
  }
  return Condition::kTruncated;
}

Condition ConditionOfJpeg(const Bytes& bytes) {
  switch (ExtentOfJpeg(bytes)) {
    case JpegExtent::kWhole:
      return Condition::kWhole;
    case JpegExtent::kNoEnd:
      return Condition::kNoEnd;
    case JpegExtent::kTruncated:
      break;
  }
  return Condition::kTruncated;
}

// Checks completeness where the file format allows it without decoding.
Condition ConditionOf(const Bytes& bytes) {
  if (StartsWith<8>(bytes, {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'})) {
    return ConditionOfPng(bytes);
  }
  if (StartsWith<3>(bytes, {0xFF, 0xD8, 0xFF})) return ConditionOfJpeg(bytes);
  return Condition::kWhole;
}

// Without a complete end marker the decoder holds back the last rows.
void EndJpeg(Bytes* bytes) {
  if (bytes->back() == 0xFF) bytes->pop_back();
  bytes->insert(bytes->end(), {0xFF, 0xD9});
}

cv::Mat Decode(const std::filesystem::path& path, int flags) {
  Bytes bytes = ReadBytes(path);
  // Checked before decoding, since libpng and libjpeg print their messages to standard error.
  const Condition condition = ConditionOf(bytes);
  if (condition == Condition::kTruncated) throw IoError(path, "is truncated");
  if (condition == Condition::kDamaged) throw IoError(path, "is damaged: a checksum is wrong");
  if (condition == Condition::kNoEnd) EndJpeg(&bytes);
  cv::Mat image;
  try {
    image = cv::imdecode(bytes, flags);
  } catch (const cv::Exception& error) {
    throw IoError(path, "cannot be decoded: " + error.err);
  }
  if (image.empty()) throw IoError(path, "is not an image or is damaged");
  return image;
}

}  // namespace

cv::Mat ReadColourImage(const std::filesystem::path& path) {
  return Decode(path, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
}

cv::Mat ReadStoredImage(const std::filesystem::path& path) {
  return Decode(path, cv::IMREAD_UNCHANGED);
}

cv::Mat ReadDepthImage(const std::filesystem::path& path) {
  cv::Mat image = ReadStoredImage(path);
  if (image.type() != CV_16UC1) {
    throw IoError(path, "is not a depth image: one channel of 16 bits is needed, found " +
                            std::to_string(image.channels()) + " of " +
                            std::to_string(8 * image.elemSize1()) + " bits");
  }
  return image;
}

}  // namespace highwall
