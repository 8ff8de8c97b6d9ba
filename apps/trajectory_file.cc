#include "trajectory_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <highwall/core/error.h>

namespace highwall::apps {
namespace {

// Where the seven numbers of a pose stand in a line, and its stamp.
struct Columns {
  std::size_t position = 0;    // x, y, z from here
  std::size_t quaternion = 0;  // four from here
  bool w_first = false;
  std::size_t stamp = 0;
  std::optional<std::size_t> nanoseconds;  // of a stamp in two parts
};

struct Line {
  std::int64_t number = 0;
  std::vector<std::string_view> fields;
};

std::string_view Trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::vector<std::string_view> Split(std::string_view text, bool commas) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t end = text.find_first_of(commas ? "," : " \t\r");
    const std::string_view field = Trimmed(text.substr(0, end));
    if (commas || !field.empty()) fields.push_back(field);
    if (end == std::string_view::npos) return fields;
    text.remove_prefix(end + 1);
  }
}

std::optional<double> Number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

// Reads a file line by line, without empty ones and comments.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path), stream_(path) {
    if (std::filesystem::is_directory(path)) throw IoError(path, "is a folder, not a file");
    if (!stream_) throw IoError(path, "cannot be opened: no such trajectory file, or not readable");
  }

  // False at the end. The last comment is kept: it may be the title.
  bool Next(Line* line) {
    while (std::getline(stream_, text_)) {
      ++line->number;
      const std::string_view text = Trimmed(text_);
      if (text.empty()) continue;
      const bool commas = text.find(',') != std::string_view::npos;
      if (text.front() == '#' || text.front() == '%') {
        title_ = text;
        continue;
      }
      line->fields = Split(text, commas);
      commas_ = commas;
      return true;
    }
    if (stream_.bad()) throw IoError(path_, "cannot be read");
    return false;
  }
  bool commas() const { return commas_; }
  const std::string& title() const { return title_; }

  [[noreturn]] void Fail(const Line& line, const std::string& what) const {
    throw IoError(path_, line.number, what);
  }
  double NumberAt(const Line& line, std::size_t column) const {
    if (column >= line.fields.size()) {
      Fail(line, "has " + std::to_string(line.fields.size()) + " values, too few for a pose");
    }
    const std::optional<double> value = Number(line.fields[column]);
    if (!value) Fail(line, "'" + std::string(line.fields[column]) + "' is not a number");
    return *value;
  }

 private:
  const std::filesystem::path& path_;
  std::ifstream stream_;
  std::string text_, title_;
  bool commas_ = false;
};

// Of `rostopic echo -p`, whose first line names the fields.
Columns RosColumns(const Reader& reader, const Line& line) {
  const std::string title = reader.title();
  const std::vector<std::string_view> names = Split(title, true);
  const auto find = [&](std::initializer_list<std::string_view> ends) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (std::ranges::any_of(ends, [&](auto end) { return names[i].ends_with(end); })) return i;
    }
    reader.Fail(line, "the title names no '" + std::string(*ends.begin()) +
                          "': expected poses as rostopic echo -p prints them");
  };
  Columns columns;
  columns.position = find({"position.x", "translation.x"});
  columns.quaternion = find({"orientation.x", "rotation.x"});
  const auto stamp = std::ranges::find_if(
      names, [](std::string_view name) { return name.ends_with("header.stamp"); });
  columns.stamp = stamp == names.end() ? 0 : static_cast<std::size_t>(stamp - names.begin());
  return columns;
}

// Of `ros2 topic echo --csv`, which names nothing: seconds, nanoseconds, one name of a frame or
// two.
std::optional<Columns> Ros2Columns(const Line& line) {
  const auto& fields = line.fields;
  if (fields.size() < 10 || !Number(fields[0]) || !Number(fields[1]) || Number(fields[2]))
    return {};
  const std::size_t position = Number(fields[3]) ? 3 : 4;
  return Columns{.position = position, .quaternion = position + 3, .stamp = 0, .nanoseconds = 1};
}

Eigen::Quaterniond QuaternionAt(const Reader& reader, const Line& line, const Columns& columns) {
  std::array<double, 4> q;
  for (std::size_t i = 0; i < 4; ++i) q[i] = reader.NumberAt(line, columns.quaternion + i);
  const Eigen::Quaterniond rotation = columns.w_first ? Eigen::Quaterniond(q[0], q[1], q[2], q[3])
                                                      : Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
  if (rotation.norm() < 1e-3) reader.Fail(line, "the quaternion is zero");
  return rotation.normalized();
}

// Digits are read as they are: a double has too few for nanoseconds of today.
Stamp StampAt(const Reader& reader, const Line& line, const Columns& columns) {
  constexpr double kMost = 9e18;  // [ns] of a Stamp
  const double number = reader.NumberAt(line, columns.stamp);
  const std::string_view text = line.fields[columns.stamp];
  if (columns.nanoseconds) {
    const double part = reader.NumberAt(line, *columns.nanoseconds);
    const std::optional<Stamp> seconds = ParseStamp(text);
    if (!seconds || std::abs(number) > 1e-9 * kMost || part < 0.0 || part >= 1e9) {
      reader.Fail(line, "'" + std::string(text) + "' is no stamp in seconds and nanoseconds");
    }
    return *seconds + static_cast<Stamp>(part);
  }
  if (std::abs(number) > kMost) reader.Fail(line, "'" + std::string(text) + "' is no stamp");
  Stamp nanoseconds = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), nanoseconds);
  if (error == std::errc() && end == text.data() + text.size()) return nanoseconds;
  return static_cast<Stamp>(std::llround(number));
}

TrajectoryFile ReadWithCommas(Reader& reader, Line line) {
  TrajectoryFile file{.format = TrajectoryFormat::kEuroc, .poses = {}};
  Columns columns{.position = 1, .quaternion = 4, .w_first = true, .stamp = 0, .nanoseconds = {}};
  if (reader.title().starts_with('%')) {
    file.format = TrajectoryFormat::kRos;
    columns = RosColumns(reader, line);
  } else if (const auto ros = Ros2Columns(line)) {
    file.format = TrajectoryFormat::kRos;
    columns = *ros;
  }
  do {
    if (!reader.commas()) reader.Fail(line, "expected values separated by commas");
    const Stamp stamp = StampAt(reader, line, columns);
    if (!file.poses.empty() && stamp < file.poses.back().stamp) {
      reader.Fail(line, "the stamp goes back in time");
    }
    const std::size_t p = columns.position;
    const Eigen::Vector3d position(reader.NumberAt(line, p), reader.NumberAt(line, p + 1),
                                   reader.NumberAt(line, p + 2));
    file.poses.push_back({stamp, Pose(QuaternionAt(reader, line, columns), position)});
  } while (reader.Next(&line));
  return file;
}

TrajectoryFile ReadKitti(Reader& reader, Line line) {
  TrajectoryFile file{.format = TrajectoryFormat::kKitti, .poses = {}};
  do {
    if (line.fields.size() != 12) {
      reader.Fail(line, "expected the 12 numbers of a 3 x 4 matrix, found " +
                            std::to_string(line.fields.size()));
    }
    Eigen::Matrix<double, 3, 4> T;
    for (int i = 0; i < 12; ++i) {
      T(i / 4, i % 4) = reader.NumberAt(line, static_cast<std::size_t>(i));
    }
    const Eigen::Matrix3d R = T.leftCols<3>();
    // Files are written with six digits or so.
    if ((R.transpose() * R - Eigen::Matrix3d::Identity()).norm() > 1e-2 || R.determinant() < 0.0) {
      reader.Fail(line, "the first 3 x 3 numbers are no rotation");
    }
    const auto seconds = static_cast<double>(file.poses.size());
    file.poses.push_back(
        {FromSeconds(seconds), Pose(Eigen::Quaterniond(R).normalized(), T.col(3))});
  } while (reader.Next(&line));
  return file;
}

}  // namespace

const char* ToString(TrajectoryFormat format) {
  switch (format) {
    case TrajectoryFormat::kTum:
      break;
    case TrajectoryFormat::kKitti:
      return "kitti";
    case TrajectoryFormat::kEuroc:
      return "euroc";
    case TrajectoryFormat::kRos:
      return "ros";
  }
  return "tum";
}

TrajectoryFile ReadTrajectoryFile(const std::filesystem::path& path) {
  Reader reader(path);
  Line line;
  if (!reader.Next(&line)) return {};
  if (reader.commas()) return ReadWithCommas(reader, std::move(line));
  if (line.fields.size() == 12) return ReadKitti(reader, std::move(line));
  return {TrajectoryFormat::kTum, ReadTumTrajectory(path)};
}

}  // namespace highwall::apps
