#include "input/ros_image.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/image_io.h>

#include "input/ros_messages.h"

namespace highwall {
namespace {

constexpr int kAsItIs = -1;
constexpr std::uint32_t kLargestSide = 1 << 15;  // [px]

struct RosPixels {
  std::string_view encoding;
  RosImageKind kind;
  int type;        // of OpenCV
  int conversion;  // to BGR
};

constexpr std::array<RosPixels, 14> kRosPixels{{
    {"rgb8", RosImageKind::kColour, CV_8UC3, cv::COLOR_RGB2BGR},
    {"bgr8", RosImageKind::kColour, CV_8UC3, kAsItIs},
    {"8UC3", RosImageKind::kColour, CV_8UC3, kAsItIs},
    {"rgba8", RosImageKind::kColour, CV_8UC4, cv::COLOR_RGBA2BGR},
    {"bgra8", RosImageKind::kColour, CV_8UC4, cv::COLOR_BGRA2BGR},
    {"8UC4", RosImageKind::kColour, CV_8UC4, cv::COLOR_BGRA2BGR},
    {"yuv422", RosImageKind::kColour, CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
    {"uyvy", RosImageKind::kColour, CV_8UC2, cv::COLOR_YUV2BGR_UYVY},
    {"yuv422_yuy2", RosImageKind::kColour, CV_8UC2, cv::COLOR_YUV2BGR_YUY2},
    {"mono8", RosImageKind::kGrey, CV_8UC1, cv::COLOR_GRAY2BGR},
    {"8UC1", RosImageKind::kGrey, CV_8UC1, cv::COLOR_GRAY2BGR},
    {"16UC1", RosImageKind::kDepth, CV_16UC1, kAsItIs},
    {"mono16", RosImageKind::kDepth, CV_16UC1, kAsItIs},
    {"32FC1", RosImageKind::kDepth, CV_32FC1, kAsItIs},
}};

const RosPixels* FindRosPixels(std::string_view encoding) {
  const auto found = std::ranges::find(kRosPixels, encoding, &RosPixels::encoding);
  return found == kRosPixels.end() ? nullptr : &*found;
}

[[noreturn]] void RefuseImage(const RosImageBytes& message, const std::string& what) {
  throw IoError(message.path, std::string(message.name) + " " + what);
}

bool IsCompressed(const BagTopic& topic) {
  return topic.type == "sensor_msgs/CompressedImage";
}

MessageReader ReaderOf(const RosImageBytes& message) {
  return {message.path, message.name, message.topic.encoding, message.bytes};
}

// Begins with the encoding of the pixels, except for plain "jpeg" and "png".
RosImageKind KindOfFormat(const BagTopic& topic, std::string_view format) {
  if (format.find("compressedDepth") != std::string_view::npos ||
      topic.name.ends_with("/compressedDepth")) {
    return RosImageKind::kDepth;
  }
  const RosPixels* const pixels = FindRosPixels(format.substr(0, format.find(';')));
  return pixels == nullptr ? RosImageKind::kColour : pixels->kind;
}

void SwapBytes(cv::Mat* image) {
  const std::size_t size = image->elemSize1();
  for (int v = 0; v < image->rows; ++v) {
    auto* const row = image->ptr<std::uint8_t>(v);
    const std::size_t bytes = static_cast<std::size_t>(image->cols) * image->elemSize();
    for (std::size_t i = 0; i < bytes; i += size) std::reverse(row + i, row + i + size);
  }
}

// Returns the pixels of an image that is not compressed, in a matrix of its own.
cv::Mat PixelsOf(const RosImageBytes& message, const RosImage& image, const RosPixels& pixels) {
  const std::uint64_t row = std::uint64_t{image.width} * CV_ELEM_SIZE(pixels.type);
  const std::uint64_t rows = image.height;
  if (image.width == 0 || rows == 0 || image.width > kLargestSide || rows > kLargestSide ||
      image.step < row || image.data.size() < (rows - 1) * image.step + row) {
    RefuseImage(message, "is damaged: " + std::to_string(image.width) + " x " +
                             std::to_string(image.height) + " pixels in " + image.encoding +
                             " cannot have " + std::to_string(image.data.size()) + " bytes");
  }
  cv::Mat result(static_cast<int>(rows), static_cast<int>(image.width), pixels.type);
  for (std::uint64_t v = 0; v < rows; ++v) {
    const ByteSpan from = image.data.subspan(v * image.step, row);
    std::ranges::copy(from, result.ptr<std::uint8_t>(static_cast<int>(v)));
  }
  constexpr bool kNative = std::endian::native == std::endian::big;
  if (image.is_big_endian != kNative && result.elemSize1() > 1) SwapBytes(&result);
  return result;
}

// 0 where nothing was measured.
void RemoveHoles(cv::Mat* metres) {
  metres->forEach<float>([](float& z, const int*) {
    if (!std::isfinite(z) || z < 0.0F) z = 0.0F;
  });
}

// The name under which a compressed image is decoded, for errors.
std::filesystem::path NameOf(const RosImageBytes& message) {
  return message.path.string() + ": " + std::string(message.name);
}

// An image of 16 bits, which are depths or, of metres, inverse depths: z = a / (value - b).
cv::Mat DecodeCompressedDepth(const RosImageBytes& message, const RosCompressedImage& image) {
  if (image.format.find("rvl") != std::string::npos) {
    RefuseImage(message, "is compressed by RVL: record the topic without compression, or as PNG");
  }
  ByteReader reader(message.path, message.name, image.data);
  reader.Skip(sizeof(std::int32_t));  // the only kind
  const auto a = reader.Number<float>(), b = reader.Number<float>();
  const ByteSpan png = reader.Take(reader.rest());
  if (png.empty()) RefuseImage(message, "is empty");
  const cv::Mat stored = DecodeDepthImage(NameOf(message), {png.begin(), png.end()});
  if (!image.format.starts_with("32FC1")) return stored;
  cv::Mat metres(stored.size(), CV_32FC1);
  for (int v = 0; v < stored.rows; ++v) {
    const auto* const value = stored.ptr<std::uint16_t>(v);
    auto* const z = metres.ptr<float>(v);
    for (int u = 0; u < stored.cols; ++u) {
      z[u] = value[u] == 0 ? 0.0F : a / (static_cast<float>(value[u]) - b);
    }
  }
  RemoveHoles(&metres);
  return metres;
}

}  // namespace

bool IsRosImage(const BagTopic& topic) {
  return topic.type == "sensor_msgs/Image" || IsCompressed(topic);
}

RosImageDescription DescribeRosImage(const RosImageBytes& message) {
  MessageReader reader = ReaderOf(message);
  RosImageDescription description;
  if (IsCompressed(message.topic)) {
    const RosCompressedImage image = ReadRosCompressedImage(&reader);
    description.is_compressed = true;
    description.kind = KindOfFormat(message.topic, image.format);
    description.in_metres = image.format.starts_with("32FC1");
    description.frame = image.header.frame;
    description.encoding = image.format;
    return description;
  }
  const RosImage image = ReadRosImage(&reader);
  const RosPixels* const pixels = FindRosPixels(image.encoding);
  if (pixels != nullptr) description.kind = pixels->kind;
  description.in_metres = pixels != nullptr && pixels->type == CV_32FC1;
  description.width = static_cast<int>(std::min(image.width, kLargestSide));
  description.height = static_cast<int>(std::min(image.height, kLargestSide));
  description.frame = image.header.frame;
  description.encoding = image.encoding;
  return description;
}

cv::Mat DecodeRosColour(const RosImageBytes& message) {
  MessageReader reader = ReaderOf(message);
  if (IsCompressed(message.topic)) {
    const RosCompressedImage image = ReadRosCompressedImage(&reader);
    if (image.data.empty()) RefuseImage(message, "is empty");
    return DecodeColourImage(NameOf(message), {image.data.begin(), image.data.end()});
  }
  const RosImage image = ReadRosImage(&reader);
  const RosPixels* const pixels = FindRosPixels(image.encoding);
  if (pixels == nullptr || pixels->kind == RosImageKind::kDepth ||
      (pixels->type == CV_8UC2 && image.width % 2 != 0)) {
    RefuseImage(message, "is in " + image.encoding +
                             "; colour is read in rgb8, bgr8, rgba8, bgra8, mono8, yuv422 and "
                             "yuv422_yuy2");
  }
  const cv::Mat stored = PixelsOf(message, image, *pixels);
  if (pixels->conversion == kAsItIs) return stored;
  cv::Mat bgr;
  cv::cvtColor(stored, bgr, pixels->conversion);
  return bgr;
}

cv::Mat DecodeRosDepth(const RosImageBytes& message) {
  MessageReader reader = ReaderOf(message);
  if (IsCompressed(message.topic)) {
    const RosCompressedImage image = ReadRosCompressedImage(&reader);
    if (image.data.empty()) RefuseImage(message, "is empty");
    if (image.format.find("compressedDepth") != std::string::npos ||
        message.topic.name.ends_with("/compressedDepth")) {
      return DecodeCompressedDepth(message, image);
    }
    return DecodeDepthImage(NameOf(message), {image.data.begin(), image.data.end()});
  }
  const RosImage image = ReadRosImage(&reader);
  const RosPixels* const pixels = FindRosPixels(image.encoding);
  if (pixels == nullptr || pixels->kind != RosImageKind::kDepth) {
    RefuseImage(message, "is in " + image.encoding + "; depth is read in 16UC1, mono16 and 32FC1");
  }
  cv::Mat stored = PixelsOf(message, image, *pixels);
  if (stored.type() == CV_32FC1) RemoveHoles(&stored);
  return stored;
}

}  // namespace highwall
