#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <highwall/core/stamp.h>

namespace highwall::apps {

// A stamp as it is written, in a unit that is not known yet: a double has too few digits for
// nanoseconds of today.
struct DecimalStamp {
  bool negative = false;
  std::uint64_t whole = 0;
  std::uint64_t billionths = 0;  // of the unit, below 1e9
};

// With a sign, a fraction, of which digits beyond the ninth are cut, and an exponent (through
// double). Empty for all else and beyond 4.6e18.
std::optional<DecimalStamp> ParseDecimalStamp(std::string_view text);

double ToDouble(const DecimalStamp& stamp);
// The nearest nanosecond, of a unit of so many [ns]. Empty beyond 4.6e9 s.
std::optional<Stamp> ToStamp(const DecimalStamp& stamp, std::int64_t unit);

}  // namespace highwall::apps
