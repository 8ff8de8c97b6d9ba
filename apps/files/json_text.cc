#include "files/json_text.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <system_error>

#include <nlohmann/json.hpp>

namespace highwall::apps {
namespace {

// UTF-8 of U+EF80 to U+EFFF: the first byte, and the range of the second byte.
constexpr unsigned char kEscape = 0xEE, kEscapeLow = 0xBE, kEscapeHigh = 0xBF;

// Length of the character that begins with a byte, and the range of its second byte (Unicode, table
// 3-7); zero length: no character begins with this byte.
struct FirstByte {
  std::size_t length = 0;
  unsigned char low = 0x80, high = 0xBF;
};

FirstByte DescribeFirst(unsigned char byte) {
  if (byte < 0x80) return {.length = 1};
  if (byte >= 0xC2 && byte <= 0xDF) return {.length = 2};
  if (byte == 0xE0) return {.length = 3, .low = 0xA0};
  if (byte == 0xED) return {.length = 3, .high = 0x9F};  // surrogates are not characters
  if (byte >= 0xE1 && byte <= 0xEF) return {.length = 3};
  if (byte == 0xF0) return {.length = 4, .low = 0x90};
  if (byte >= 0xF1 && byte <= 0xF3) return {.length = 4};
  if (byte == 0xF4) return {.length = 4, .high = 0x8F};
  return {};
}

unsigned char At(std::string_view text, std::size_t i) {
  return static_cast<unsigned char>(text[i]);
}

// Returns the length in bytes of the first character of `text`; 0 if it is not UTF-8.
std::size_t CharacterLength(std::string_view text) {
  const FirstByte first = DescribeFirst(At(text, 0));
  if (first.length == 0 || text.size() < first.length) return 0;
  for (std::size_t i = 1; i < first.length; ++i) {
    const unsigned char low = i == 1 ? first.low : 0x80, high = i == 1 ? first.high : 0xBF;
    if (At(text, i) < low || At(text, i) > high) return 0;
  }
  return first.length;
}

bool IsEscape(std::string_view character) {
  return character.size() == 3 && At(character, 0) == kEscape &&
         (At(character, 1) == kEscapeLow || At(character, 1) == kEscapeHigh);
}

std::string Escaped(unsigned char byte) {
  return {static_cast<char>(kEscape), static_cast<char>(byte < 0xC0 ? kEscapeLow : kEscapeHigh),
          static_cast<char>(0x80U | (byte & 0x3FU))};
}

template <typename Json>
Json InUtf8(const Json& value) {
  if (value.is_string()) return ToUtf8(value.template get_ref<const std::string&>());
  if (!value.is_structured()) return value;
  Json result = value.is_array() ? Json::array() : Json::object();
  for (const auto& [key, element] : value.items()) {
    if (value.is_array()) {
      result.push_back(InUtf8(element));
    } else {
      result[ToUtf8(key)] = InUtf8(element);
    }
  }
  return result;
}

}  // namespace

std::string ToUtf8(std::string_view bytes) {
  std::string text;
  while (!bytes.empty()) {
    const std::size_t length = CharacterLength(bytes);
    if (length > 0 && !IsEscape(bytes.substr(0, length))) {
      text += bytes.substr(0, length);
      bytes.remove_prefix(length);
    } else {
      text += Escaped(At(bytes, 0));
      bytes.remove_prefix(1);
    }
  }
  return text;
}

std::string FromUtf8(std::string_view text) {
  std::string bytes;
  while (!text.empty()) {
    const std::size_t length = std::max<std::size_t>(CharacterLength(text), 1);
    const std::string_view character = text.substr(0, length);
    if (IsEscape(character)) {
      const unsigned base = At(character, 1) == kEscapeLow ? 0x80U : 0xC0U;
      bytes += static_cast<char>(base | (At(character, 2) & 0x3FU));
    } else {
      bytes += character;
    }
    text.remove_prefix(length);
  }
  return bytes;
}

std::string JsonText(const nlohmann::json& value, int indent) {
  return InUtf8(value).dump(indent);
}

std::string JsonText(const nlohmann::ordered_json& value, int indent) {
  return InUtf8(value).dump(indent);
}

nlohmann::json ReadJson(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return nullptr;  // a folder, a pipe
  std::ifstream stream(path);
  return stream ? nlohmann::json::parse(stream, nullptr, false) : nlohmann::json();
}

std::string StringIn(const nlohmann::json& value) {
  return FromUtf8(value.get_ref<const std::string&>());
}

}  // namespace highwall::apps
