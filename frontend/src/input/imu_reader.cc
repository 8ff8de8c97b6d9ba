#include <highwall/frontend/input/dataset.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <highwall/core/error.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/text_file.h>

#include "input/imu_columns.h"

namespace highwall {
namespace {

constexpr std::int64_t kNano = 1'000'000'000;

// Bound that keeps the difference of two stamps representable.
constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max() / 2;

// A stamp as written, in a unit that is not known yet: whole + nano * 1e-9.
struct RawStamp {
  std::int64_t whole = 0;
  std::int64_t nano = 0;  // in [0, 1e9)
};

struct Unit {
  const char* name;
  std::int64_t nanoseconds;
};
constexpr std::array<Unit, 4> kUnits{Unit{"nanoseconds", 1},
                                     {"microseconds", 1000},
                                     {"milliseconds", 1'000'000},
                                     {"seconds", kNano}};
constexpr const Unit& kNanoseconds = kUnits[0];
constexpr const Unit& kSeconds = kUnits[3];

struct RawReading {
  std::int64_t line = 0;
  RawStamp stamp;
  std::array<double, 6> values{};
};

struct RawRecording {
  std::vector<RawReading> readings;
  bool decimal = false;  // some stamp has a decimal point or an exponent
  bool reversed_accelerometer = false;
};

bool ParseRawStamp(std::string_view text, RawStamp* stamp) {
  const std::size_t point = text.find_first_of(".eE");
  if (point == std::string_view::npos) return ParseNumber(text, &stamp->whole);
  if (text.find_first_of("eE") != std::string_view::npos || text.front() == '-') {
    double value = 0.0;
    if (!ParseNumber(text, &value) || !(std::abs(value) < 9e18)) return false;
    stamp->whole = static_cast<std::int64_t>(std::floor(value));
    stamp->nano = static_cast<std::int64_t>((value - std::floor(value)) * 1e9);
    return true;
  }
  std::string fraction(text.substr(point + 1, 9));
  fraction.resize(9, '0');
  return ParseNumber(text.substr(0, point), &stamp->whole) && stamp->whole >= 0 &&
         fraction.front() != '-' && ParseNumber(std::string_view(fraction), &stamp->nano);
}

// Parses the number of a field; an empty field becomes NaN, which is left out later. With
// semicolons as separators, commas may be decimal.
bool ParseField(std::string_view field, double* value) {
  if (field.empty()) {
    *value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  std::string text(field.starts_with('+') ? field.substr(1) : field);
  std::ranges::replace(text, ',', '.');
  return ParseNumber(std::string_view(text), value);
}

// named: the columns of a heading, if it names them; without it a line must hold exactly the fields
// of a reading.
std::vector<std::string_view> FieldsOf(const std::filesystem::path& path, std::int64_t number,
                                       std::string_view line,
                                       const std::optional<ImuColumns>& named) {
  std::vector<std::string_view> fields = ImuFields(line);
  const std::size_t count = named.value_or(ImuColumns()).count();
  while (!named && fields.size() > count && fields.back().empty()) fields.pop_back();
  if (named ? fields.size() >= count : fields.size() == count) return fields;
  throw IoError(path, number,
                "has " + std::to_string(fields.size()) +
                    " fields; a reading is a stamp, three of the gyroscope [rad/s] and three of "
                    "the accelerometer [m/s^2]" +
                    (fields.size() < count
                         ? ""
                         : "; of more a heading must name these: t,w_x,w_y,w_z,a_x,a_y,a_z"));
}

RawReading ParseLine(const std::filesystem::path& path, std::int64_t number,
                     const std::vector<std::string_view>& fields, const ImuColumns& columns) {
  RawReading reading;
  reading.line = number;
  std::string stamp(fields[columns.stamp]);
  std::ranges::replace(stamp, ',', '.');
  if (!ParseRawStamp(stamp, &reading.stamp) || reading.stamp.whole > kLatest ||
      reading.stamp.whole < -kLatest) {
    throw IoError(
        path, number,
        "'" + stamp + "' is not a time stamp; write whole nanoseconds or decimal seconds");
  }
  if (columns.nanoseconds) {
    const std::string_view part = fields[*columns.nanoseconds];
    if (!ParseNumber(part, &reading.stamp.nano) || reading.stamp.nano < 0 ||
        reading.stamp.nano >= kNano) {
      throw IoError(path, number,
                    "'" + std::string(part) + "' is no part of a second in nanoseconds");
    }
  }
  for (std::size_t i = 0; i < reading.values.size(); ++i) {
    const std::string_view field = fields[columns.values[i]];
    if (!ParseField(field, &reading.values[i])) {
      throw IoError(path, number,
                    "'" + std::string(field) + "' is not a number; correct the line or remove it");
    }
  }
  return reading;
}

// The first name may be empty: pandas does not name its index.
bool IsImuHeading(std::string_view line) {
  const char first = line[line.find_first_not_of(" \t\r,;")];
  return std::isalpha(static_cast<unsigned char>(first)) != 0 || first == '"';
}

RawRecording ReadLines(const std::filesystem::path& path) {
  TextReader file(ReadTextFile(path));
  RawRecording recording;
  std::optional<ImuColumns> named;
  bool heading_allowed = true;
  std::string line;
  for (std::int64_t number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r,;") == std::string::npos) continue;
    line.erase(0, line.find_first_not_of(" \t"));
    const bool comment = line.front() == '#' || line.front() == '%';
    if (comment || (heading_allowed && IsImuHeading(line))) {
      if (recording.readings.empty() && !named) named = FindImuColumns(line);
      heading_allowed &= comment;
      continue;
    }
    heading_allowed = false;
    const std::vector<std::string_view> fields = FieldsOf(path, number, line, named);
    const ImuColumns columns = named.value_or(ImuColumns());
    recording.readings.push_back(ParseLine(path, number, fields, columns));
    recording.reversed_accelerometer = columns.reversed_accelerometer;
    recording.decimal |= columns.nanoseconds.has_value() ||
                         fields[columns.stamp].find_first_of(".,eE") != std::string_view::npos;
  }
  if (recording.readings.empty()) {
    throw IoError(path, "holds no reading; remove it to run without an IMU");
  }
  return recording;
}

// Returns nothing if it is too large for a Stamp.
std::optional<Stamp> Convert(const RawStamp& stamp, const Unit& unit) {
  const std::int64_t limit = kLatest / unit.nanoseconds - 1;
  if (stamp.whole > limit || stamp.whole < -limit) return std::nullopt;
  return stamp.whole * unit.nanoseconds + stamp.nano * unit.nanoseconds / kNano;
}

std::optional<VideoSpan> SpanIn(const RawRecording& recording, const Unit& unit) {
  VideoSpan span{std::numeric_limits<Stamp>::max(), std::numeric_limits<Stamp>::min()};
  for (const RawReading& reading : recording.readings) {
    const std::optional<Stamp> stamp = Convert(reading.stamp, unit);
    if (!stamp) return std::nullopt;
    span.begin = std::min(span.begin, *stamp);
    span.end = std::max(span.end, *stamp);
  }
  return span;
}

// Returns the median step between neighbours [units]; 0 for a single reading.
double MedianStep(const RawRecording& recording) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < recording.readings.size(); ++i) {
    const RawStamp& a = recording.readings[i - 1].stamp;
    const RawStamp& b = recording.readings[i].stamp;
    steps.push_back(static_cast<double>(b.whole - a.whole) +
                    static_cast<double>(b.nano - a.nano) / static_cast<double>(kNano));
  }
  return steps.empty() ? 0.0 : UpperMedian(std::move(steps));
}

// 10 to 10,000 readings per second: three orders of magnitude, the ratio of two units.
bool IsUsualStep(double step, const Unit& unit) {
  const double seconds = step * static_cast<double>(unit.nanoseconds) * 1e-9;
  return seconds > 1e-4 && seconds <= 0.1;
}

std::string Seconds(const VideoSpan& span) {
  return FormatStamp(span.begin) + " to " + FormatStamp(span.end) + " s";
}

// Returns the unit in which the readings overlap the video; of several the one with a usual rate.
const Unit& FindUnit(const std::filesystem::path& path, const RawRecording& recording,
                     const VideoSpan& video) {
  const Unit& written = recording.decimal ? kSeconds : kNanoseconds;
  const double step = MedianStep(recording);
  const Unit* best = nullptr;
  bool best_is_usual = false;
  for (const Unit* unit : {&written, &kUnits[0], &kUnits[1], &kUnits[2], &kUnits[3]}) {
    const std::optional<VideoSpan> span = SpanIn(recording, *unit);
    if (!span || span->begin > video.end || span->end < video.begin) continue;
    const bool usual = IsUsualStep(step, *unit);
    if (best == nullptr || (usual && !best_is_usual)) {
      best = unit;
      best_is_usual = usual;
    }
  }
  if (best != nullptr) return *best;
  const auto likely = std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& unit) {
    return IsUsualStep(step, unit) && SpanIn(recording, unit);
  });
  const std::optional<VideoSpan> span =
      SpanIn(recording, likely == kUnits.end() ? written : *likely);
  throw IoError(path, "its stamps" + (span ? " (" + Seconds(*span) + ")" : std::string()) +
                          " do not meet those of the video (" + Seconds(video) +
                          "): another clock; write both in one clock, or run with --imu off");
}

}  // namespace

std::optional<std::filesystem::path> FindImuFile(const std::filesystem::path& dataset) {
  std::error_code ignored;
  for (const char* name : {"imu.csv", "imu.txt", "imu0/data.csv", "mav0/imu0/data.csv"}) {
    if (std::filesystem::is_regular_file(dataset / name, ignored)) return dataset / name;
  }
  return std::nullopt;
}

ImuRecording ReadImu(const std::filesystem::path& path, const VideoSpan& video) {
  HIGHWALL_REQUIRE(video.begin <= video.end, "ReadImu: the video must not end before it begins");
  const RawRecording raw = ReadLines(path);
  const Unit& unit = FindUnit(path, raw, video);
  ImuRecording recording;
  if (&unit != (raw.decimal ? &kSeconds : &kNanoseconds)) {
    recording.warning = path.string() + ": its stamps are in " + unit.name + ", not in " +
                        (raw.decimal ? kSeconds : kNanoseconds).name + "; converted";
  }
  if (raw.reversed_accelerometer) {
    recording.warning += recording.warning.empty() ? path.string() + ": " : "; ";
    recording.warning +=
        "its accelerometer reads gravity, as iOS has it, not its reaction: the sign is reversed";
  }
  const double sign = raw.reversed_accelerometer ? -1.0 : 1.0;
  recording.samples.reserve(raw.readings.size());
  for (const RawReading& reading : raw.readings) {
    const auto& v = reading.values;
    recording.samples.push_back({Convert(reading.stamp, unit).value(),
                                 {v[0], v[1], v[2]},
                                 sign * Eigen::Vector3d(v[3], v[4], v[5])});
    recording.lines.push_back(reading.line);
  }
  return recording;
}

}  // namespace highwall
