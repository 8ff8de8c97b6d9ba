#include <highwall/core/stamp.h>

#include <cmath>

#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

constexpr Stamp kNanosecondsPerSecond = 1'000'000'000;
constexpr std::int64_t kMaxSeconds = kMaxStamp / kNanosecondsPerSecond;

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

}  // namespace

std::optional<Stamp> ParseStamp(std::string_view text) {
  if (text.find_first_of("eE") != std::string_view::npos) {
    if (text.starts_with("+") && !text.starts_with("+-"))
      text.remove_prefix(1);  // not accepted by ParseNumber
    double seconds = 0.0;
    if (!ParseNumber(text, &seconds)) return std::nullopt;
    if (!(std::abs(seconds) <= static_cast<double>(kMaxSeconds))) return std::nullopt;
    return FromSeconds(seconds);
  }
  std::size_t i = 0;
  const bool negative = !text.empty() && text[0] == '-';
  if (!text.empty() && (text[0] == '-' || text[0] == '+')) ++i;
  bool any_digit = false;
  std::int64_t whole = 0;
  for (; i < text.size() && IsDigit(text[i]); ++i, any_digit = true) {
    whole = whole * 10 + (text[i] - '0');
    if (whole > kMaxSeconds) return std::nullopt;
  }
  std::int64_t fraction = 0;
  if (i < text.size() && text[i] == '.') {
    std::int64_t unit = kNanosecondsPerSecond / 10;
    for (++i; i < text.size() && IsDigit(text[i]); ++i, any_digit = true) {
      fraction += (text[i] - '0') * unit;
      unit /= 10;
    }
  }
  if (!any_digit || i != text.size()) return std::nullopt;
  const Stamp stamp = whole * kNanosecondsPerSecond + fraction;
  return negative ? -stamp : stamp;
}

std::string FormatStamp(Stamp stamp) {
  const bool negative = stamp < 0;
  const std::uint64_t magnitude = negative ? std::uint64_t{0} - static_cast<std::uint64_t>(stamp)
                                           : static_cast<std::uint64_t>(stamp);
  const std::uint64_t whole = magnitude / kNanosecondsPerSecond;
  std::string fraction = std::to_string(magnitude % kNanosecondsPerSecond);
  fraction.insert(0, 9 - fraction.size(), '0');
  while (fraction.size() > 6 && fraction.back() == '0') fraction.pop_back();
  return (negative ? "-" : "") + std::to_string(whole) + "." + fraction;
}

Stamp FromSeconds(double seconds) {
  return std::llround(seconds * 1e9);
}

}  // namespace highwall
