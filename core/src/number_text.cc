#include <highwall/internal/number_text.h>

#include <algorithm>
#include <array>

namespace highwall {
namespace {

constexpr int kMaxDecimals = 100;

template <typename... Format>
std::string ToText(Format... format) {
  std::array<char, 512> text;  // room for the largest double with all its decimals
  const auto result = std::to_chars(text.data(), text.data() + text.size(), format...);
  return {text.data(), result.ptr};
}

}  // namespace

std::string NumberText(double value) {
  return ToText(value);
}

std::string NumberText(float value) {
  return ToText(value);
}

std::string FixedText(double value, int decimals) {
  return ToText(value, std::chars_format::fixed, std::clamp(decimals, 0, kMaxDecimals));
}

std::string RoundedText(double value, int digits) {
  return ToText(value, std::chars_format::general, std::clamp(digits, 1, kMaxDecimals));
}

std::vector<std::string_view> SplitWords(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> words;
  for (std::size_t at = text.find_first_not_of(separators); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(separators, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(separators, end);
  }
  return words;
}

}  // namespace highwall
