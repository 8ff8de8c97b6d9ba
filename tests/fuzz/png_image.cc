#include "input/png_image.h"

#include <libdeflate.h>

#include <algorithm>
#include <memory>

#include "fuzz.h"

namespace highwall::fuzz {
namespace {

std::string BigEndianText(std::size_t value) {
  std::string text;
  for (const int shift : {24, 16, 8, 0}) text += static_cast<char>(value >> shift & 0xFFU);
  return text;
}

std::string Chunk(const std::string& type, const std::string& data) {
  const std::string content = type + data;
  return BigEndianText(data.size()) + content +
         BigEndianText(libdeflate_crc32(0, content.data(), content.size()));
}

std::string Header(std::size_t width, std::size_t height, char bits, char colour) {
  return BigEndianText(width) + BigEndianText(height) + bits + colour + std::string(3, '\0');
}

// Input: 13 bytes of IHDR, then rows with their filters, which are compressed here.
std::string MakePng(std::string_view input) {
  const std::size_t split = std::min<std::size_t>(13, input.size());
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> deflate(
      libdeflate_alloc_compressor(1), &libdeflate_free_compressor);
  const std::string_view rows = input.substr(split);
  std::string data(libdeflate_zlib_compress_bound(deflate.get(), rows.size()), '\0');
  data.resize(libdeflate_zlib_compress(deflate.get(), rows.data(), rows.size(), data.data(),
                                       data.size()));
  return "\x89PNG\r\n\x1A\n" + Chunk("IHDR", std::string(input.substr(0, split))) +
         Chunk("IDAT", data.substr(0, data.size() / 2)) +
         Chunk("IDAT", data.substr(data.size() / 2)) + Chunk("IEND", "");
}

}  // namespace

const Target kTarget{
    .file_name = "image.png",
    .seeds =
        [] {
          return std::vector<std::string>{
              Header(2, 2, 8, 2) + "\1abcdef" + "\4ghijkl",
              Header(3, 2, 16, 0) + "\2abcdef" + "\3ghijkl",
              Header(4, 1, 8, 0) + std::string(1, '\0') + "abcd"};
        },
    .file = MakePng,
    .read =
        [](const std::filesystem::path& path) {
          const std::string text = ReadBytes(path);
          const std::vector<std::uint8_t> bytes(text.begin(), text.end());
          if (IsPng(bytes) && ConditionOfPng(bytes) == PngCondition::kWhole) DecodePng(bytes);
        },
};

}  // namespace highwall::fuzz
