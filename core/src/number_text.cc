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

}  // namespace highwall
