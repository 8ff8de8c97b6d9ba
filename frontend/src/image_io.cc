#include <highwall/frontend/image_io.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include <highwall/core/error.h>

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

// Walks the chunks (length, type, data, checksum; PNG specification, section 5.3) to IEND.
bool PngIsComplete(const Bytes& bytes) {
  constexpr std::size_t kSignature = 8, kOverhead = 12;
  const std::array<std::uint8_t, 4> end{'I', 'E', 'N', 'D'};
  std::size_t at = kSignature;
  while (bytes.size() - at >= kOverhead) {
    const std::size_t length = std::size_t{bytes[at]} << 24 | std::size_t{bytes[at + 1]} << 16 |
                               std::size_t{bytes[at + 2]} << 8 | std::size_t{bytes[at + 3]};
    if (length > bytes.size() - at - kOverhead) return false;
    const auto type = bytes.begin() + static_cast<std::ptrdiff_t>(at) + 4;
    if (std::equal(end.begin(), end.end(), type)) return true;
    at += length + kOverhead;
  }
  return false;
}

// The end-of-image marker FF D9 closes the file; some cameras pad a few bytes behind it.
bool JpegIsComplete(const Bytes& bytes) {
  constexpr std::ptrdiff_t kPadding = 64;
  const std::array<std::uint8_t, 2> end{0xFF, 0xD9};
  const auto from = bytes.end() - std::min(std::ssize(bytes), kPadding);
  return std::search(from, bytes.end(), end.begin(), end.end()) != bytes.end();
}

bool IsTruncated(const Bytes& bytes) {
  if (StartsWith<8>(bytes, {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'})) {
    return !PngIsComplete(bytes);
  }
  if (StartsWith<3>(bytes, {0xFF, 0xD8, 0xFF})) return !JpegIsComplete(bytes);
  return false;
}

cv::Mat Decode(const std::filesystem::path& path, int flags) {
  const Bytes bytes = ReadBytes(path);
  // Checked before decoding: libpng and libjpeg write their complaints to standard error.
  if (IsTruncated(bytes)) throw IoError(path, "is truncated");
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

cv::Mat ReadDepthImage(const std::filesystem::path& path) {
  const cv::Mat image = Decode(path, cv::IMREAD_UNCHANGED);
  if (image.type() != CV_16UC1) {
    throw IoError(path, "is not a depth image: one channel of 16 bits is needed, found " +
                            std::to_string(image.channels()) + " of " +
                            std::to_string(8 * image.elemSize1()) + " bits");
  }
  return image;
}

}  // namespace highwall
