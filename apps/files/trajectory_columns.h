#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

// Column layout of a table of poses, from its heading or its values.
namespace highwall::apps {

// [ns] per unit of time.
inline constexpr std::int64_t kSecond = 1'000'000'000, kMillisecond = 1'000'000,
                              kMicrosecond = 1'000, kNanosecond = 1;

struct TrajectoryColumns {
  std::size_t stamp = 0;
  std::optional<std::size_t> nanoseconds;                   // second part of a split stamp
  std::array<std::size_t, 7> pose = {1, 2, 3, 4, 5, 6, 7};  // x y z qx qy qz qw
  std::optional<std::int64_t> unit;                         // [ns] of stamps, if known

  bool operator==(const TrajectoryColumns&) const = default;
  std::size_t Last() const;
};

// stamp x y z qw qx qy qz
inline constexpr std::array<std::size_t, 7> kScalarFirst = {1, 2, 3, 5, 6, 7, 4};

std::string_view TrimmedBlanks(std::string_view text);
// Splits at `separator`; at blanks and tabs if that is a blank.
std::vector<std::string_view> SplitFields(std::string_view text, char separator);
// Returns ';' if the line has one, otherwise ',', otherwise ' '.
char SeparatorOf(std::string_view line);

// Derives the layout from the names of a heading, with or without # or % in front, above lines of
// `width` values. Empty if it names no quaternion, no position, or more columns than there are.
std::optional<TrajectoryColumns> ColumnsByName(std::string_view heading, std::size_t width);

struct TimeUnit {
  std::int64_t nanoseconds = kSecond;
  bool sure = true;
};

// Infers the unit of stamps from the resulting years, and from the resulting pose rate, which is
// that of a sensor. `table`: separated by commas, where seconds are not the default.
TimeUnit GuessTimeUnit(std::span<const double> stamps, bool table);
// Returns false if poses would follow each other by less than 10 us or more than a day.
bool IsPossibleUnit(std::span<const double> stamps, std::int64_t unit);

}  // namespace highwall::apps
