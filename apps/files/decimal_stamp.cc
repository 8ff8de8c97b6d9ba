#include "files/decimal_stamp.h"

#include <charconv>
#include <cmath>

namespace highwall::apps {
namespace {

constexpr std::uint64_t kBillion = 1'000'000'000;
// The difference of two stamps must be representable as well.
constexpr std::uint64_t kMostTicks = 4'600'000'000 * kBillion;

std::optional<DecimalStamp> FromExponent(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (!(value <= static_cast<double>(kMostTicks))) return std::nullopt;
  DecimalStamp stamp{.whole = static_cast<std::uint64_t>(value)};
  const double rest = value - static_cast<double>(stamp.whole);
  stamp.billionths = static_cast<std::uint64_t>(std::llround(1e9 * rest));
  if (stamp.billionths < kBillion) return stamp;
  return DecimalStamp{.whole = stamp.whole + 1};
}

}  // namespace

std::optional<DecimalStamp> ParseDecimalStamp(std::string_view text) {
  DecimalStamp stamp{.negative = text.starts_with('-')};
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  if (text.empty() || text.front() == '-') return std::nullopt;
  if (text.find_first_of("eE") != std::string_view::npos) {
    auto of_exponent = FromExponent(text);
    if (of_exponent) of_exponent->negative = stamp.negative;
    return of_exponent;
  }
  std::uint64_t unit = kBillion;
  bool any_digit = false, point = false;
  for (const char c : text) {
    if (c == '.' && !point) {
      point = true;
      continue;
    }
    if (c < '0' || c > '9') return std::nullopt;
    any_digit = true;
    const auto digit = static_cast<std::uint64_t>(c - '0');
    if (point) {
      unit /= 10;
      stamp.billionths += digit * unit;
      continue;
    }
    stamp.whole = 10 * stamp.whole + digit;
    if (stamp.whole > kMostTicks) return std::nullopt;
  }
  if (!any_digit) return std::nullopt;
  return stamp;
}

double ToDouble(const DecimalStamp& stamp) {
  const double size =
      static_cast<double>(stamp.whole) + 1e-9 * static_cast<double>(stamp.billionths);
  return stamp.negative ? -size : size;
}

std::optional<Stamp> ToStamp(const DecimalStamp& stamp, std::int64_t unit) {
  const auto ticks = static_cast<std::uint64_t>(unit);
  if (stamp.whole > kMostTicks / ticks) return std::nullopt;
  const auto size = static_cast<Stamp>(stamp.whole * ticks +
                                       (stamp.billionths * ticks + kBillion / 2) / kBillion);
  return stamp.negative ? -size : size;
}

}  // namespace highwall::apps
