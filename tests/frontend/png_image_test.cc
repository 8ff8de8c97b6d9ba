#include "input/png_image.h"

#include <libdeflate.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "support/crc32.h"

namespace highwall::png_image_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes BigEndian(std::size_t value) {
  Bytes bytes;
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
  return bytes;
}

void Append(const Bytes& from, Bytes* to) { to->insert(to->end(), from.begin(), from.end()); }

Bytes Chunk(const std::string& type, const Bytes& data) {
  Bytes chunk = BigEndian(data.size());
  const std::string content = type + std::string(data.begin(), data.end());
  chunk.insert(chunk.end(), content.begin(), content.end());
  Append(BigEndian(testing::Crc32(content)), &chunk);
  return chunk;
}

Bytes Compressed(const Bytes& bytes) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> deflate(
      libdeflate_alloc_compressor(6), &libdeflate_free_compressor);
  Bytes out(libdeflate_zlib_compress_bound(deflate.get(), bytes.size()));
  out.resize(libdeflate_zlib_compress(deflate.get(), bytes.data(), bytes.size(), out.data(),
                                      out.size()));
  return out;
}

constexpr int kWidth = 37, kHeight = 24;

// A file of random filtered rows, row y with filter y modulo 5, its data in `parts` chunks.
Bytes RandomFile(int colour, int bits, int bytes_per_pixel, std::size_t parts) {
  Bytes rows;
  std::uint32_t state = 7;
  for (int y = 0; y < kHeight; ++y) {
    rows.push_back(static_cast<std::uint8_t>(y % 5));
    for (int i = 0; i < kWidth * bytes_per_pixel; ++i) {
      state = state * 1664525U + 1013904223U;
      rows.push_back(static_cast<std::uint8_t>(state >> 24U));
    }
  }
  Bytes header = BigEndian(kWidth);
  Append(BigEndian(kHeight), &header);
  Append({static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(colour), 0, 0, 0}, &header);
  Bytes file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  Append(Chunk("IHDR", header), &file);
  Append(Chunk("tEXt", {'a', 0, 'b'}), &file);
  const Bytes data = Compressed(rows);
  for (std::size_t k = 0; k < parts; ++k) {
    const auto at = [&](std::size_t part) {
      return data.begin() + static_cast<std::ptrdiff_t>(data.size() * part / parts);
    };
    Append(Chunk("IDAT", Bytes(at(k), at(k + 1))), &file);
  }
  Append(Chunk("IEND", {}), &file);
  return file;
}

TEST(PngImage, EqualsOpenCvForEveryFilterKindAndNumberOfChunks) {
  struct Kind {
    int colour, bits, bytes, type;
  };
  for (const Kind& kind : {Kind{0, 8, 1, CV_8UC1}, {0, 16, 2, CV_16UC1}, {2, 8, 3, CV_8UC3}}) {
    for (const std::size_t parts : {1U, 2U, 5U}) {
      const Bytes file = RandomFile(kind.colour, kind.bits, kind.bytes, parts);
      ASSERT_TRUE(IsPng(file));
      ASSERT_EQ(ConditionOfPng(file), PngCondition::kWhole);
      const auto image = DecodePng(file);
      ASSERT_TRUE(image);
      ASSERT_EQ(image->type(), kind.type);
      const cv::Mat expected = cv::imdecode(file, cv::IMREAD_UNCHANGED);
      ASSERT_EQ(image->size(), expected.size());
      EXPECT_EQ(cv::norm(*image, expected, cv::NORM_INF), 0.0) << kind.bytes << " " << parts;
    }
  }
}

TEST(PngImage, LeavesKindsThatCamerasDoNotWriteToOthers) {
  Bytes bytes;
  ASSERT_TRUE(cv::imencode(".png", cv::Mat(9, 8, CV_16UC3, cv::Scalar::all(700)), bytes));
  EXPECT_FALSE(DecodePng(bytes));
  ASSERT_TRUE(cv::imencode(".png", cv::Mat(9, 8, CV_8UC4, cv::Scalar::all(70)), bytes));
  EXPECT_FALSE(DecodePng(bytes));
  ASSERT_TRUE(cv::imencode(".png", cv::Mat(9, 8, CV_8UC1, cv::Scalar(255)), bytes,
                           {cv::IMWRITE_PNG_BILEVEL, 1}));
  EXPECT_FALSE(DecodePng(bytes));
}

TEST(PngImage, FindsEveryCutAndEveryChangedByte) {
  const Bytes file = RandomFile(2, 8, 3, 2);
  constexpr std::size_t kSignature = 8;
  for (std::size_t size = kSignature; size < file.size(); size += 31) {
    const Bytes cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(ConditionOfPng(cut), PngCondition::kTruncated) << size;
  }
  for (std::size_t at = kSignature; at < file.size(); at += 31) {
    Bytes changed = file;
    changed[at] = static_cast<std::uint8_t>(changed[at] ^ 0x10U);
    EXPECT_NE(ConditionOfPng(changed), PngCondition::kWhole) << at;
  }
}

TEST(PngImage, DoesNotBelieveASizeThatTheDataCannotHold) {
  Bytes file = RandomFile(0, 16, 2, 1);
  // 32768 x 32768, checksum of the header made anew.
  Bytes header = BigEndian(1U << 15U);
  Append(BigEndian(1U << 15U), &header);
  Append({16, 0, 0, 0, 0}, &header);
  const Bytes chunk = Chunk("IHDR", header);
  std::copy(chunk.begin(), chunk.end(), file.begin() + 8);
  ASSERT_EQ(ConditionOfPng(file), PngCondition::kWhole);
  EXPECT_FALSE(DecodePng(file));
}

}  // namespace
}  // namespace highwall::png_image_test
