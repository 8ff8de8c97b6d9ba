#include <highwall/frontend/input/image_io.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>

#include "input/jpeg_extent.h"
#include "input/jpeg_image.h"
#include "input/media_module.h"
#include "input/png_image.h"

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

[[noreturn]] void RefuseTruncated(const std::filesystem::path& path) {
  throw IoError(path, "is truncated");
}

// Without a complete end marker the decoder holds back the last rows.
void EndJpeg(Bytes* bytes) {
  if (bytes->back() == 0xFF) bytes->pop_back();
  bytes->insert(bytes->end(), {0xFF, 0xD9});
}

// The decoder warns of every file that ends early, and only then is it worth to count the blocks.
std::optional<cv::Mat> ReadJpeg(const std::filesystem::path& path, Bytes bytes) {
  auto image = DecodeJpeg(bytes);
  if (!image || image->has_warnings) {
    const JpegExtent extent = ExtentOfJpeg(bytes);
    if (extent == JpegExtent::kTruncated) RefuseTruncated(path);
    if (extent == JpegExtent::kNoEnd) {
      EndJpeg(&bytes);
      image = DecodeJpeg(bytes);
    }
  }
  if (!image) return std::nullopt;
  return image->pixels;
}

std::optional<cv::Mat> ReadPng(const std::filesystem::path& path, const Bytes& bytes) {
  // Checked before decoding, since libpng prints its messages to standard error.
  switch (ConditionOfPng(bytes)) {
    case PngCondition::kTruncated:
      RefuseTruncated(path);
    case PngCondition::kDamaged:
      throw IoError(path, "is damaged: a checksum is wrong");
    case PngCondition::kWhole:
      break;
  }
  return DecodePng(bytes);
}

// Decodes what cameras write. Returns nullopt for other formats and kinds.
std::optional<cv::Mat> DecodeDirectly(const std::filesystem::path& path, const Bytes& bytes) {
  if (IsPng(bytes)) return ReadPng(path, bytes);
  if (IsJpeg(bytes)) return ReadJpeg(path, bytes);
  return std::nullopt;
}

cv::Mat DecodeByOpenCv(const std::filesystem::path& path, const Bytes& bytes,
                       cv::ImreadModes mode) {
  std::string problem;
  const cv::Mat image = MediaFor(path).decode_image(bytes, mode, &problem);
  if (!problem.empty()) throw IoError(path, "cannot be decoded: " + problem);
  if (image.empty()) throw IoError(path, "is not an image or is damaged");
  return image;
}

}  // namespace

cv::Mat DecodeColourImage(const std::filesystem::path& path, const Bytes& bytes) {
  const auto image = DecodeDirectly(path, bytes);
  if (image && image->type() == CV_8UC3) return *image;
  if (image && image->type() == CV_8UC1) {
    cv::Mat colour;
    cv::cvtColor(*image, colour, cv::COLOR_GRAY2BGR);
    return colour;
  }
  return DecodeByOpenCv(path, bytes,
                        cv::ImreadModes(cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION));
}

cv::Mat DecodeDepthImage(const std::filesystem::path& path, const Bytes& bytes) {
  const auto decoded = DecodeDirectly(path, bytes);
  cv::Mat image = decoded ? *decoded : DecodeByOpenCv(path, bytes, cv::IMREAD_UNCHANGED);
  if (image.type() != CV_16UC1) {
    throw IoError(path, "is not a depth image: one channel of 16 bits is needed, found " +
                            std::to_string(image.channels()) + " of " +
                            std::to_string(8 * image.elemSize1()) + " bits");
  }
  return image;
}

cv::Mat ReadColourImage(const std::filesystem::path& path) {
  return DecodeColourImage(path, ReadBytes(path));
}

cv::Mat ReadGreyImage(const std::filesystem::path& path) {
  const Bytes bytes = ReadBytes(path);
  const auto image = DecodeDirectly(path, bytes);
  if (image && image->type() == CV_8UC1) return *image;
  return DecodeByOpenCv(path, bytes,
                        cv::ImreadModes(cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION));
}

cv::Mat ReadStoredImage(const std::filesystem::path& path) {
  const Bytes bytes = ReadBytes(path);
  const auto image = DecodeDirectly(path, bytes);
  return image ? *image : DecodeByOpenCv(path, bytes, cv::IMREAD_UNCHANGED);
}

cv::Mat ReadDepthImage(const std::filesystem::path& path) {
  return DecodeDepthImage(path, ReadBytes(path));
}

}  // namespace highwall
