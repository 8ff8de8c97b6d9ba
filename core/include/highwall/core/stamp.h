#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

// Time stamps are int64 nanoseconds everywhere: a double holds a UNIX time in seconds to no better
// than 0.2 microseconds, and two spellings of one stamp must compare equal.
namespace [[gnu::visibility("default")]] highwall {

// Nanoseconds.
using Stamp = std::int64_t;
// 146 years: the difference of two stamps that are no farther from zero is a stamp.
inline constexpr Stamp kMaxStamp = 4'600'000'000'000'000'000;

// "1305031102.175304" -> 1305031102175304000, exactly; digits beyond the ninth are cut. Accepts a
// sign, a missing fraction, an exponent (through double). Empty for all else and beyond 4.6e9 s.
std::optional<Stamp> ParseStamp(std::string_view seconds);

// The inverse, at least 6 and at most 9 decimals: "1305031102.175304".
std::string FormatStamp(Stamp stamp);

// [s] of a duration.
constexpr double ToSeconds(Stamp duration) {
  return static_cast<double>(duration) * 1e-9;
}
// The nearest stamp.
Stamp FromSeconds(double seconds);

}  // namespace highwall
