#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <highwall/core/stamp.h>

namespace highwall::apps {

// Decimal stamp as written, in a unit that is not yet known: a double has too few digits for
// current nanosecond stamps.
struct DecimalStamp {
  bool negative = false;
  std::uint64_t whole = 0;
  std::uint64_t billionths = 0;  // of the unit, below 1e9
};

// Parses a number with optional sign, fraction (digits beyond the ninth are truncated) and exponent
// (parsed as double). Returns an empty result for other text and beyond 4.6e18.
std::optional<DecimalStamp> ParseDecimalStamp(std::string_view text);

double ToDouble(const DecimalStamp& stamp);
// Converts a stamp to nanoseconds, rounded to nearest. unit: [ns]. Empty beyond 4.6e9 s.
std::optional<Stamp> ToStamp(const DecimalStamp& stamp, std::int64_t unit);

}  // namespace highwall::apps
