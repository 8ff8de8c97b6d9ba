#include <highwall/internal/text_file.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

#include <highwall/core/error.h>

namespace highwall {
namespace {

constexpr std::string_view kUtf8Mark = "\xef\xbb\xbf";
constexpr std::string_view kLittleEndianMark = "\xff\xfe", kBigEndianMark = "\xfe\xff";

void AppendUtf8(std::uint32_t code, std::string* text) {
  const auto append = [text](std::uint32_t byte) { text->push_back(static_cast<char>(byte)); };
  const auto tail = [&](unsigned shift) { append(0x80U | (code >> shift & 0x3FU)); };
  if (code < 0x80U) return append(code);
  if (code < 0x800U) {
    append(0xC0U | code >> 6U);
  } else {
    if (code < 0x10000U) {
      append(0xE0U | code >> 12U);
    } else {
      append(0xF0U | code >> 18U);
      tail(12);
    }
    tail(6);
  }
  tail(0);
}

std::string FromUtf16(std::string_view bytes, bool big_endian) {
  std::string text;
  const auto unit = [&](std::size_t at) {
    const auto first = static_cast<unsigned char>(bytes[at]);
    const auto second = static_cast<unsigned char>(bytes[at + 1]);
    return big_endian ? std::uint32_t{first} << 8U | second : std::uint32_t{second} << 8U | first;
  };
  for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) {
    std::uint32_t code = unit(at);
    const bool high = code >= 0xD800U && code < 0xDC00U;
    if (high && at + 3 < bytes.size()) {  // first half of a surrogate pair
      code = 0x10000U + ((code & 0x3FFU) << 10U) + (unit(at + 2) & 0x3FFU);
      at += 2;
    }
    AppendUtf8(code, &text);
  }
  return text;
}

// UTF-16 text of digits and Latin letters without a byte-order mark, recognized by the zero byte of
// its first letter.
bool LooksLikeUtf16(std::string_view bytes, std::size_t zero) {
  return bytes.size() >= 4 && bytes[zero] == '\0' && bytes[zero + 2] == '\0' &&
         bytes[1 - zero] != '\0' && bytes[3 - zero] != '\0';
}

}  // namespace

std::string ReadTextFile(const std::filesystem::path& path) {
  std::error_code error;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, error)) {
    throw IoError(path, "is missing or cannot be read");
  }
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  const std::string_view view = bytes;
  if (view.starts_with(kUtf8Mark)) {
    bytes.erase(0, kUtf8Mark.size());
  } else if (view.starts_with(kLittleEndianMark)) {
    bytes = FromUtf16(view.substr(2), false);
  } else if (view.starts_with(kBigEndianMark)) {
    bytes = FromUtf16(view.substr(2), true);
  } else if (LooksLikeUtf16(view, 1)) {
    bytes = FromUtf16(view, false);
  } else if (LooksLikeUtf16(view, 0)) {
    bytes = FromUtf16(view, true);
  }
  if (bytes.find('\n') == std::string::npos) std::ranges::replace(bytes, '\r', '\n');
  return bytes;
}

}  // namespace highwall
