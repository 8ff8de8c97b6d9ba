#include "input/imu_columns.h"

#include <algorithm>
#include <cctype>
#include <string>

namespace highwall {
namespace {

constexpr std::string_view kImuBlanks = " \t\r";

std::string_view TrimmedField(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(kImuBlanks), text.size());
  text.remove_prefix(begin);
  return text.substr(0, text.find_last_not_of(kImuBlanks) + 1);
}

// Returns the heading in lower case, without text in brackets and without signs before the first
// name.
std::string PlainHeading(std::string_view heading) {
  std::string plain;
  int depth = 0;
  for (const char c : heading) {
    if (c == '[' || c == '(') ++depth;
    if (depth == 0 && c != '"') {
      plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    if ((c == ']' || c == ')') && depth > 0) --depth;
  }
  return plain.substr(std::min(plain.find_first_not_of("#% \t"), plain.size()));
}

bool HoldsAny(std::string_view name, std::initializer_list<std::string_view> parts) {
  return std::ranges::any_of(
      parts, [name](std::string_view part) { return name.find(part) != std::string_view::npos; });
}

// Returns 0 to 2 for x to z at the end or the beginning of a name.
std::optional<std::size_t> AxisOf(std::string_view name) {
  const auto axis = [](char c) -> std::optional<std::size_t> {
    if (c < 'x' || c > 'z') return std::nullopt;
    return static_cast<std::size_t>(c - 'x');
  };
  const std::size_t last = name.find_last_not_of("_. ");
  if (last == std::string_view::npos) return std::nullopt;
  if (const auto at_end = axis(name[last])) return at_end;
  return name.size() > 1 && HoldsAny(name.substr(1, 1), {"_", ".", "-"}) ? axis(name[0])
                                                                         : std::nullopt;
}

// A letter that stands for the quantity: in "wx", "w_x" and "w_rs_s_x", not in "week_x".
bool IsSymbol(std::string_view name, char symbol) {
  return name.size() > 1 && name[0] == symbol &&
         (name.size() == 2 || std::isalpha(static_cast<unsigned char>(name[1])) == 0);
}

bool IsOfOtherKind(std::string_view name) {
  return HoldsAny(
      name, {"mag", "orient", "quat", "gravity", "cov", "bias", "temp", "euler", "std", "sigma",
             "noise", "angular_acc", "angularacc", "rotvec", "rotation_vector"});
}

// Quantities that phones derive from the readings, without gravity; in ROS "linear" is only a word.
bool IsDerived(std::string_view name) {
  return HoldsAny(name, {"user", "linear"});
}

// The name of an angular rate in the recordings of Stray Scanner, and in no others.
bool IsOfStrayScanner(std::string_view name) {
  return name.starts_with("alpha_");
}

bool IsGyroscope(std::string_view name) {
  return HoldsAny(name, {"gyr", "omega", "angular", "ang_vel", "angvel", "rotationrate",
                         "rotation_rate", "rot_rate", "rotation"}) ||
         IsOfStrayScanner(name) || IsSymbol(name, 'w') || IsSymbol(name, 'g');
}

bool IsAccelerometer(std::string_view name) {
  return HoldsAny(name, {"acc", "specific_force", "specificforce"}) || IsSymbol(name, 'a');
}

bool IsStamp(std::string_view name) {
  return name == "t" || name == "ts" || HoldsAny(name, {"time", "stamp"});
}

bool IsNanoseconds(std::string_view name) {
  return name.ends_with("stamp.nsecs") || name.ends_with("stamp.nanosec");
}

}  // namespace

std::size_t ImuColumns::count() const {
  return 1 + std::max({stamp, nanoseconds.value_or(0), *std::ranges::max_element(values)});
}

std::vector<std::string_view> ImuFields(std::string_view line) {
  line = TrimmedField(line);
  std::string_view separator = kImuBlanks;
  for (const std::string_view sign : {",", ";"}) {
    if (line.find(sign) != std::string_view::npos) separator = sign;
  }
  const bool blanks = separator == kImuBlanks;
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t end = std::min(line.find_first_of(separator), line.size());
    fields.push_back(TrimmedField(line.substr(0, end)));
    if (end == line.size()) return fields;
    line.remove_prefix(end + 1);
    if (blanks) line = TrimmedField(line);
  }
}

std::optional<ImuColumns> FindImuColumns(std::string_view heading) {
  const std::string plain = PlainHeading(heading);
  std::array<std::optional<std::size_t>, 6> values;
  std::optional<std::size_t> stamp, nanoseconds;
  const std::vector<std::string_view> names = ImuFields(plain);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string_view name = names[i];
    if (IsNanoseconds(name)) {
      nanoseconds = i;
      continue;
    }
    if (!stamp && IsStamp(name)) {
      stamp = i;
      continue;
    }
    const std::optional<std::size_t> axis = AxisOf(name);
    if (!axis || IsOfOtherKind(name)) continue;
    const bool gyroscope = IsGyroscope(name);
    if (!gyroscope && !IsAccelerometer(name)) continue;
    std::optional<std::size_t>& value = values[*axis + (gyroscope ? 0 : 3)];
    if (!value || (IsDerived(names[*value]) && !IsDerived(name))) value = i;
  }
  ImuColumns columns{.stamp = stamp.value_or(0)};
  const std::string_view seconds = names[columns.stamp];
  if (seconds.ends_with("stamp.secs") || seconds.ends_with("stamp.sec")) {
    columns.nanoseconds = nanoseconds;
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i] || *values[i] == columns.stamp) return std::nullopt;
    columns.values[i] = *values[i];
  }
  columns.reversed_accelerometer = IsOfStrayScanner(names[columns.values[0]]);
  return columns;
}

}  // namespace highwall
