#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

// Time stamps are int64 nanoseconds everywhere: a double resolves a UNIX time in seconds only to
// 0.2 microseconds, and two spellings of one stamp must compare equal.
namespace [[gnu::visibility("default")]] highwall {

// Nanoseconds.
using Stamp = std::int64_t;
// 146 years: the difference of two stamps within +-kMaxStamp does not overflow.
inline constexpr Stamp kMaxStamp = 4'600'000'000'000'000'000;

// Parses "1305031102.175304" to 1305031102175304000 exactly; digits after the ninth decimal are
// truncated. Accepts a sign, a missing fraction, an exponent (through double). Empty for any other
// text and beyond 4.6e9 s.
std::optional<Stamp> ParseStamp(std::string_view seconds);

// Inverse of ParseStamp, with 6 to 9 decimals: "1305031102.175304".
std::string FormatStamp(Stamp stamp);

// Converts a duration to seconds.
constexpr double ToSeconds(Stamp duration) {
  return static_cast<double>(duration) * 1e-9;
}
// Converts seconds to the nearest stamp.
Stamp FromSeconds(double seconds);

}  // namespace highwall
