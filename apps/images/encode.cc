#include "images/encode.h"

#include <libdeflate.h>
#include <turbojpeg.h>

#include <array>
#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string_view>
#include <type_traits>

namespace highwall {
namespace {

using Bytes = std::vector<std::uint8_t>;

void AppendBigEndian(std::uint32_t value, Bytes* bytes) {
  for (const int shift : {24, 16, 8, 0})
    bytes->push_back(static_cast<std::uint8_t>(value >> shift));
}

void AppendChunk(std::string_view type, std::span<const std::uint8_t> data, Bytes* file) {
  AppendBigEndian(static_cast<std::uint32_t>(data.size()), file);
  const std::size_t begin = file->size();
  file->insert(file->end(), type.begin(), type.end());
  file->insert(file->end(), data.begin(), data.end());
  AppendBigEndian(libdeflate_crc32(0, &(*file)[begin], file->size() - begin), file);
}

struct PngKind {
  std::uint8_t bits = 0, colour = 0;
  // Where the bytes of a pixel of PNG lie in a pixel of OpenCV.
  std::vector<std::size_t> order;
};

PngKind KindOf(const cv::Mat& image) {
  switch (image.empty() ? -1 : image.type()) {
    case CV_8UC1:
      return {8, 0, {0}};
    case CV_16UC1:
      return {16, 0, {1, 0}};
    case CV_8UC3:
      return {8, 2, {2, 1, 0}};
    case CV_8UC4:
      return {8, 6, {2, 1, 0, 3}};
    default:
      throw std::invalid_argument("EncodePng: grey of 8 or 16 bits, BGR or BGRA is needed");
  }
}

// Returns the rows, each of them after the number of its filter: the difference from the pixel on
// the left, which suits smooth images and costs little.
Bytes FilteredRows(const cv::Mat& image, const PngKind& kind) {
  constexpr std::uint8_t kSub = 1;
  const std::size_t pixel = kind.order.size(), width = static_cast<std::size_t>(image.cols);
  Bytes rows;
  rows.reserve((1 + width * pixel) * static_cast<std::size_t>(image.rows));
  for (int y = 0; y < image.rows; ++y) {
    rows.push_back(kSub);
    std::array<std::uint8_t, 4> left{};
    const std::uint8_t* from = image.ptr(y);
    for (std::size_t x = 0; x < width; ++x, from += pixel) {
      for (std::size_t k = 0; k < pixel; ++k) {
        const std::uint8_t value = from[kind.order[k]];
        rows.push_back(static_cast<std::uint8_t>(value - left[k]));
        left[k] = value;
      }
    }
  }
  return rows;
}

Bytes Compress(std::span<const std::uint8_t> bytes, int level) {
  if (level < 0 || level > 12) {
    throw std::invalid_argument("EncodePng: the compression must be from 0 to 12");
  }
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> deflate(
      libdeflate_alloc_compressor(level), &libdeflate_free_compressor);
  if (!deflate) throw std::bad_alloc();
  Bytes out(libdeflate_zlib_compress_bound(deflate.get(), bytes.size()));
  out.resize(
      libdeflate_zlib_compress(deflate.get(), bytes.data(), bytes.size(), out.data(), out.size()));
  return out;
}

}  // namespace

Bytes EncodePng(const cv::Mat& image, int compression) {
  const PngKind kind = KindOf(image);
  Bytes header;
  AppendBigEndian(static_cast<std::uint32_t>(image.cols), &header);
  AppendBigEndian(static_cast<std::uint32_t>(image.rows), &header);
  header.insert(header.end(), {kind.bits, kind.colour, 0, 0, 0});
  Bytes file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  AppendChunk("IHDR", header, &file);
  AppendChunk("IDAT", Compress(FilteredRows(image, kind), compression), &file);
  AppendChunk("IEND", {}, &file);
  return file;
}

Bytes EncodeJpeg(const cv::Mat& image, int quality) {
  if (image.empty() || (image.type() != CV_8UC1 && image.type() != CV_8UC3)) {
    throw std::invalid_argument("EncodeJpeg: grey or BGR of 8 bits is needed");
  }
  const bool grey = image.type() == CV_8UC1;
  const std::unique_ptr<std::remove_pointer_t<tjhandle>, decltype(&tjDestroy)> encoder(
      tjInitCompress(), &tjDestroy);
  if (!encoder) throw std::bad_alloc();
  unsigned char* encoded = nullptr;
  unsigned long size = 0;
  const int status = tjCompress2(
      encoder.get(), image.data, image.cols, static_cast<int>(image.step), image.rows,
      grey ? TJPF_GRAY : TJPF_BGR, &encoded, &size, grey ? TJSAMP_GRAY : TJSAMP_420, quality, 0);
  const std::unique_ptr<unsigned char, decltype(&tjFree)> owner(encoded, &tjFree);
  if (status != 0) throw std::invalid_argument(tjGetErrorStr2(encoder.get()));
  return Bytes(encoded, encoded + size);
}

}  // namespace highwall
