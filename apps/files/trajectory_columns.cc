#include "files/trajectory_columns.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>

#include <highwall/internal/median.h>

namespace highwall::apps {
namespace {

constexpr std::string_view kBlank = " \t\r";
constexpr double kFirstYears = 5e8, kLastYears = 4.6e9;  // [s] since 1970: 1985 to 2115
constexpr double kUsualPace = 0.03;                      // [s] of a camera
constexpr double kLeastPace = 1e-5, kMostPace = 10.0;    // [s] between poses

struct ColumnName {
  std::string text;  // in lower case
  std::string unit;  // in brackets after the name
};

bool IsOneOf(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, text) != words.end();
}

bool ContainsAny(std::string_view text, std::initializer_list<std::string_view> parts) {
  return std::ranges::any_of(
      parts, [&](std::string_view part) { return text.find(part) != std::string_view::npos; });
}

ColumnName NameOf(std::string_view field) {
  ColumnName name;
  const std::size_t bracket = std::min(field.find_first_of("[("), field.size());
  for (const char c : TrimmedBlanks(field.substr(0, bracket))) {
    if (c != '"') name.text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  field.remove_prefix(std::min(bracket + 1, field.size()));
  name.unit = TrimmedBlanks(field.substr(0, field.find_first_of("])")));
  return name;
}

// Replaces vectors that have one name, as in OpenVINS, by their components. OpenVINS stores the JPL
// quaternion from world to body, which is numerically the Hamilton quaternion from body to world
// used here.
std::vector<ColumnName> Expanded(const std::vector<ColumnName>& names) {
  const auto named = [&](std::string_view text) {
    return std::ranges::find(names, text, &ColumnName::text) != names.end();
  };
  if (!named("q") || !named("p")) return names;
  std::vector<ColumnName> expanded;
  for (const ColumnName& name : names) {
    if (!IsOneOf(name.text, {"q", "p", "v", "bg", "ba"})) {
      expanded.push_back(name);
      continue;
    }
    for (const char component : std::string_view(name.text == "q" ? "xyzw" : "xyz")) {
      expanded.push_back({name.text + component, ""});
    }
  }
  return expanded;
}

std::vector<ColumnName> NamesOf(std::string_view heading) {
  heading.remove_prefix(std::min(heading.find_first_not_of("#% \t"), heading.size()));
  const char separator = SeparatorOf(heading);
  std::vector<ColumnName> names;
  for (const std::string_view field : SplitFields(heading, separator)) {
    const bool unit = separator == ' ' && !names.empty() && field.find_first_of("[(") == 0;
    if (unit) {
      names.back().unit = NameOf(field).unit;
    } else {
      names.push_back(NameOf(field));
    }
  }
  return Expanded(names);
}

// Returns 'w' and "q_rs" for "q_rs_w"; no component if the name means something else.
std::pair<char, std::string_view> ComponentOf(std::string_view name) {
  if (name.empty() || std::string_view("wxyz").find(name.back()) == std::string_view::npos) {
    return {'\0', {}};
  }
  const std::string_view whole = name.substr(0, name.size() - 1);
  return {name.back(), whole.substr(0, whole.find_last_not_of("_.-/: ") + 1)};
}

bool IsQuaternion(std::string_view whole) {
  return whole == "q" || whole.starts_with("q_") || whole.starts_with("qvec") ||
         ContainsAny(whole, {"quat", "orient", "rot"});
}

bool IsPosition(std::string_view whole) {
  if (IsQuaternion(whole) || ContainsAny(whole, {"twist", "vel", "acc", "linear", "angular"})) {
    return false;
  }
  return IsOneOf(whole, {"", "p", "t", "pos", "trans", "tvec"}) || whole.starts_with("p_") ||
         whole.starts_with("t_") || ContainsAny(whole, {"position", "translation", "location"});
}

bool IsStamp(std::string_view name) {
  return IsOneOf(name, {"t", "ts", "t_s", "t_ns", "t_us", "t_ms", "sec", "secs", "seconds"}) ||
         ContainsAny(name, {"time", "stamp"});
}

std::optional<std::int64_t> UnitNamed(std::string_view unit) {
  if (IsOneOf(unit, {"ns", "nsec", "nsecs", "nanosec", "nanoseconds"})) return kNanosecond;
  if (IsOneOf(unit, {"us", "usec", "\xc2\xb5s", "microseconds"})) return kMicrosecond;
  if (IsOneOf(unit, {"ms", "msec", "milliseconds"})) return kMillisecond;
  if (IsOneOf(unit, {"s", "sec", "secs", "seconds"})) return kSecond;
  return std::nullopt;
}

std::optional<std::int64_t> UnitOf(const ColumnName& name) {
  if (const auto unit = UnitNamed(name.unit)) return unit;
  return UnitNamed(std::string_view(name.text).substr(name.text.find_last_of("_.") + 1));
}

template <class Is>
std::optional<std::size_t> FirstThat(const std::vector<ColumnName>& names, const Is& is) {
  const auto found = std::ranges::find_if(names, is, &ColumnName::text);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

// Finds the columns of components; those missing in a truncated heading follow in order.
template <class Is, std::size_t kCount>
bool FindComponents(const std::vector<ColumnName>& names, const Is& is, std::string_view components,
                    std::span<std::size_t, kCount> columns) {
  const auto named = [&](char component) {
    return FirstThat(names, [&](std::string_view name) {
      const auto [c, whole] = ComponentOf(name);
      return c == component && is(whole);
    });
  };
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto column = named(components[i]);
    const bool follows = i > 0 && columns[i - 1] + 1 >= names.size();
    if (!column && !follows) return false;
    columns[i] = column ? *column : columns[i - 1] + 1;
  }
  return true;
}

void FindStamp(const std::vector<ColumnName>& names, TrajectoryColumns* columns) {
  const auto ending = [&](std::initializer_list<std::string_view> ends) {
    return FirstThat(names, [&](std::string_view name) {
      return std::ranges::any_of(ends, [&](auto end) { return name.ends_with(end); });
    });
  };
  const auto seconds = ending({"stamp.secs", "stamp.sec"});
  const auto nanoseconds = ending({"stamp.nsecs", "stamp.nanosec"});
  if (seconds && nanoseconds) {
    columns->stamp = *seconds;
    columns->nanoseconds = nanoseconds;
    columns->unit = kSecond;
    return;
  }
  const auto header = ending({"header.stamp"});
  columns->stamp = header ? *header : FirstThat(names, IsStamp).value_or(0);
  columns->unit = UnitOf(names[columns->stamp]);
}

// [s] Returns the median of the non-zero intervals; zero if there is none.
double PaceOf(std::span<const double> stamps) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double interval = std::abs(stamps[i] - stamps[i - 1]);
    if (interval > 0.0) intervals.push_back(interval);
  }
  return intervals.empty() ? 0.0 : UpperMedian(std::move(intervals));
}

bool IsPace(double seconds) {
  return seconds >= kLeastPace && seconds <= kMostPace;
}

}  // namespace

std::size_t TrajectoryColumns::Last() const {
  return std::max({stamp, nanoseconds.value_or(0), *std::ranges::max_element(pose)});
}

std::string_view TrimmedBlanks(std::string_view text) {
  const auto begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

std::vector<std::string_view> SplitFields(std::string_view text, char separator) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t end =
        separator == ' ' ? text.find_first_of(kBlank) : text.find_first_of(separator);
    const std::string_view field = TrimmedBlanks(text.substr(0, end));
    if (separator != ' ' || !field.empty()) fields.push_back(field);
    if (end == std::string_view::npos) return fields;
    text.remove_prefix(end + 1);
  }
}

char SeparatorOf(std::string_view line) {
  for (const char separator : {';', ','}) {
    if (line.find(separator) != std::string_view::npos) return separator;
  }
  return ' ';
}

std::optional<TrajectoryColumns> ColumnsByName(std::string_view heading, std::size_t width) {
  std::vector<ColumnName> names = NamesOf(heading);
  if (names.size() > width) {  // "# columns: stamp tx ty ..."
    names.erase(names.begin(), std::ranges::find_if(names, IsStamp, &ColumnName::text));
  }
  TrajectoryColumns columns;
  std::array<std::size_t, 4> q{};
  const bool w_first = [&] {
    const auto first = FirstThat(names, [](std::string_view name) {
      const auto [c, whole] = ComponentOf(name);
      return c != '\0' && IsQuaternion(whole);
    });
    return first && names[*first].text.back() == 'w';
  }();
  if (!FindComponents(names, IsPosition, "xyz", std::span(columns.pose).first<3>())) {
    return std::nullopt;
  }
  if (w_first) {
    if (!FindComponents(names, IsQuaternion, "wxyz", std::span(q))) return std::nullopt;
    std::rotate(q.begin(), q.begin() + 1, q.end());
  } else if (!FindComponents(names, IsQuaternion, "xyzw", std::span(q))) {
    return std::nullopt;
  }
  std::ranges::copy(q, columns.pose.begin() + 3);
  FindStamp(names, &columns);
  const bool taken = std::ranges::find(columns.pose, columns.stamp) != columns.pose.end();
  if (taken || columns.Last() >= width) return std::nullopt;
  return columns;
}

TimeUnit GuessTimeUnit(std::span<const double> stamps, bool table) {
  constexpr std::array kUnits = {kSecond, kMillisecond, kMicrosecond, kNanosecond};
  if (stamps.empty()) return {};
  const double size = std::abs(UpperMedian(std::vector(stamps.begin(), stamps.end())));
  const double pace = PaceOf(stamps);
  const auto seconds = [](double value, std::int64_t unit) {
    return 1e-9 * value * static_cast<double>(unit);
  };
  const auto is_of_today = [&](std::int64_t unit) {
    return seconds(size, unit) >= kFirstYears && seconds(size, unit) <= kLastYears;
  };
  for (const std::int64_t unit : kUnits) {
    if (is_of_today(unit) && (pace == 0.0 || IsPace(seconds(pace, unit)))) return {unit, true};
  }
  if (is_of_today(kSecond) && IsPossibleUnit(stamps, kSecond)) return {kSecond, true};
  if (size <= kLastYears && (pace == 0.0 || IsPace(pace))) return {kSecond, true};
  if (size <= kLastYears && !table && IsPossibleUnit(stamps, kSecond)) return {kSecond, false};
  TimeUnit best{size <= kLastYears && pace == 0.0 ? kSecond : kNanosecond, false};
  double least = INFINITY;
  for (const std::int64_t unit : {kMillisecond, kMicrosecond, kNanosecond}) {
    if (!IsPace(seconds(pace, unit))) continue;
    const double distance = std::abs(std::log(seconds(pace, unit) / kUsualPace));
    if (distance < least) best.nanoseconds = unit;
    least = std::min(least, distance);
  }
  return best;
}

bool IsPossibleUnit(std::span<const double> stamps, std::int64_t unit) {
  const double pace = 1e-9 * PaceOf(stamps) * static_cast<double>(unit);
  return pace == 0.0 || (pace >= kLeastPace && pace <= 86'400.0);
}

}  // namespace highwall::apps
