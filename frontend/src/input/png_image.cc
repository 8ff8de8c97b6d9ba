#include "input/png_image.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

namespace highwall {
namespace {

using ByteSpan = std::span<const std::uint8_t>;

constexpr std::array<std::uint8_t, 8> kPngSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

std::uint32_t BigEndian(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24U | std::uint32_t{bytes[1]} << 16U |
         std::uint32_t{bytes[2]} << 8U | std::uint32_t{bytes[3]};
}

struct PngChunk {
  ByteSpan type_and_data;
  ByteSpan data;
  std::uint32_t checksum = 0;

  bool Is(const char* name) const { return std::memcmp(type_and_data.data(), name, 4) == 0; }
};

// Returns the chunk at the beginning of bytes and drops it from them; nullopt if it is cut.
std::optional<PngChunk> NextChunk(ByteSpan* bytes) {
  constexpr std::size_t kOverhead = 12;  // length, type and checksum
  if (bytes->size() < kOverhead) return std::nullopt;
  const std::size_t length = BigEndian(bytes->data());
  if (length > bytes->size() - kOverhead) return std::nullopt;
  const ByteSpan type_and_data = bytes->subspan(4, 4 + length);
  const PngChunk chunk{type_and_data, type_and_data.subspan(4), BigEndian(&(*bytes)[8 + length])};
  *bytes = bytes->subspan(length + kOverhead);
  return chunk;
}

struct PngHeader {
  std::size_t width = 0, height = 0;
  std::size_t pixel_bytes = 0;  // 1: grey, 2: grey of 16 bits, 3: RGB

  std::size_t Stride() const { return width * pixel_bytes; }
  // Each row is preceded by the number of its filter.
  std::size_t FilteredSize() const { return (1 + Stride()) * height; }
};

// Returns nullopt for the kinds that DecodePng leaves to others.
std::optional<PngHeader> ReadPngHeader(const PngChunk& chunk) {
  if (!chunk.Is("IHDR") || chunk.data.size() != 13) return std::nullopt;
  const std::uint8_t* const data = chunk.data.data();
  const int bits = data[8], colour = data[9];
  const bool plain = data[10] == 0 && data[11] == 0 && data[12] == 0;
  const bool rgb = colour == 2 && bits == 8, grey = colour == 0 && (bits == 8 || bits == 16);
  if (!plain || !(rgb || grey)) return std::nullopt;
  constexpr std::uint32_t kMaxSide = 1U << 15U;
  const std::uint32_t width = BigEndian(data), height = BigEndian(data + 4);
  if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide) return std::nullopt;
  return PngHeader{width, height, rgb ? 3U : static_cast<std::size_t>(bits / 8)};
}

struct PngContent {
  PngHeader header;
  std::vector<std::uint8_t> joined;  // image data of several chunks
  ByteSpan compressed;
};

std::optional<PngContent> ReadPngContent(ByteSpan bytes) {
  bytes = bytes.subspan(kPngSignature.size());
  const auto first = NextChunk(&bytes);
  const auto header = first ? ReadPngHeader(*first) : std::nullopt;
  if (!header) return std::nullopt;
  PngContent content{*header, {}, {}};
  while (const auto chunk = NextChunk(&bytes)) {
    if (chunk->Is("IEND")) break;
    if (chunk->Is("tRNS")) return std::nullopt;  // transparent: not what cameras write
    if (!chunk->Is("IDAT")) continue;
    if (content.compressed.empty()) {
      content.compressed = chunk->data;
    } else {
      if (content.joined.empty()) {
        content.joined.reserve(bytes.size() + chunk->data.size() + content.compressed.size());
        content.joined.assign(content.compressed.begin(), content.compressed.end());
      }
      content.joined.insert(content.joined.end(), chunk->data.begin(), chunk->data.end());
      content.compressed = content.joined;
    }
  }
  return content;
}

// Returns nullptr if the data is damaged or of another size.
std::unique_ptr<std::uint8_t[]> Decompress(ByteSpan compressed, std::size_t size) {
  constexpr std::size_t kLargestRatio = 1032;  // of deflate: a header cannot claim any size
  if (size / kLargestRatio > compressed.size()) return nullptr;
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> inflate(
      libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  if (!inflate) return nullptr;
  auto bytes = std::make_unique_for_overwrite<std::uint8_t[]>(size);
  const libdeflate_result result = libdeflate_zlib_decompress(
      inflate.get(), compressed.data(), compressed.size(), bytes.get(), size, nullptr);
  return result == LIBDEFLATE_SUCCESS ? std::move(bytes) : nullptr;
}

// Ties go to the left, then to the value above. Without branches: noise makes them unpredictable.
std::uint8_t Paeth(int left, int above, int corner) {
  const int from_left = std::abs(above - corner), from_above = std::abs(left - corner);
  const int from_corner = std::abs(left + above - 2 * corner);
  const int nearer = from_above < from_left ? above : left;
  return static_cast<std::uint8_t>(from_corner < std::min(from_left, from_above) ? corner : nearer);
}

// Undoes the filter of a row in place. above: the row before it, or zeros; kPixel: bytes of a pixel.
template <std::size_t kPixel>
bool Unfilter(int filter, std::span<std::uint8_t> row, const std::uint8_t* above) {
  constexpr int kNone = 0, kSub = 1, kUp = 2, kAverage = 3, kPaeth = 4;
  const std::size_t size = row.size();
  std::uint8_t* const x = row.data();
  std::array<std::uint8_t, kPixel> left{}, corner{};
  const auto each_pixel = [&](auto predict) {
    for (std::size_t i = 0; i < size; i += kPixel) {
      for (std::size_t k = 0; k < kPixel; ++k) {
        const std::uint8_t up = above[i + k];
        left[k] = static_cast<std::uint8_t>(x[i + k] + predict(left[k], up, corner[k]));
        corner[k] = up;
        x[i + k] = left[k];
      }
    }
  };
  switch (filter) {
    case kNone:
      return true;
    case kSub:
      each_pixel([](std::uint8_t l, std::uint8_t, std::uint8_t) { return l; });
      return true;
    case kUp:
      for (std::size_t i = 0; i < size; ++i) x[i] = static_cast<std::uint8_t>(x[i] + above[i]);
      return true;
    case kAverage:
      each_pixel([](std::uint8_t l, std::uint8_t u, std::uint8_t) {
        return static_cast<std::uint8_t>((l + u) / 2);
      });
      return true;
    case kPaeth:
      each_pixel([](std::uint8_t l, std::uint8_t u, std::uint8_t c) { return Paeth(l, u, c); });
      return true;
    default:
      return false;
  }
}

// Stores a row in the order of bytes and channels of OpenCV.
template <std::size_t kPixel>
void StoreRow(std::span<const std::uint8_t> row, std::uint8_t* out) {
  for (std::size_t i = 0; i < row.size(); i += kPixel) {
    for (std::size_t k = 0; k < kPixel; ++k) out[i + k] = row[i + kPixel - 1 - k];
  }
}

template <std::size_t kPixel>
bool StoreRows(std::uint8_t* bytes, const PngHeader& header, cv::Mat* image) {
  const std::vector<std::uint8_t> zeros(header.Stride());
  const std::uint8_t* above = zeros.data();
  for (int y = 0; y < image->rows; ++y) {
    const std::span<std::uint8_t> row(bytes + 1, header.Stride());
    if (!Unfilter<kPixel>(bytes[0], row, above)) return false;
    StoreRow<kPixel>(row, image->ptr(y));
    above = row.data();
    bytes += 1 + header.Stride();
  }
  return true;
}

}  // namespace

bool IsPng(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= kPngSignature.size() &&
         std::equal(kPngSignature.begin(), kPngSignature.end(), bytes.begin());
}

PngCondition ConditionOfPng(std::span<const std::uint8_t> bytes) {
  bytes = bytes.subspan(kPngSignature.size());
  while (const auto chunk = NextChunk(&bytes)) {
    const ByteSpan checked = chunk->type_and_data;
    if (libdeflate_crc32(0, checked.data(), checked.size()) != chunk->checksum) {
      return PngCondition::kDamaged;
    }
    if (chunk->Is("IEND")) return PngCondition::kWhole;
  }
  return PngCondition::kTruncated;
}

std::optional<cv::Mat> DecodePng(std::span<const std::uint8_t> bytes) {
  const auto content = ReadPngContent(bytes);
  if (!content) return std::nullopt;
  const PngHeader& header = content->header;
  const auto filtered = Decompress(content->compressed, header.FilteredSize());
  if (!filtered) return std::nullopt;
  constexpr std::array<int, 4> kTypes{0, CV_8UC1, CV_16UC1, CV_8UC3};
  cv::Mat image(static_cast<int>(header.height), static_cast<int>(header.width),
                kTypes[header.pixel_bytes]);
  const auto store = header.pixel_bytes == 1   ? StoreRows<1>
                     : header.pixel_bytes == 2 ? StoreRows<2>
                                               : StoreRows<3>;
  if (!store(filtered.get(), header, &image)) return std::nullopt;
  return image;
}

}  // namespace highwall
