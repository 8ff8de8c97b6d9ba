#include "files/trajectory_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/text_file.h>

#include "files/decimal_stamp.h"
#include "files/trajectory_columns.h"

namespace highwall::apps {
namespace {

constexpr std::array kPoseNames = {"tx", "ty", "tz", "qx", "qy", "qz", "qw"};
constexpr std::string_view kTumColumns = "'stamp tx ty tz qx qy qz qw' separated by blanks";

struct Line {
  std::int64_t number = 0;
  std::vector<std::string_view> fields;
};

// NaN and infinity are numbers here, because they are not names.
std::optional<double> Number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

// Between semicolons or blanks, a comma inside a number is a decimal comma.
bool HasDecimalCommas(std::string_view line) {
  if (line.find(',') == std::string_view::npos) return false;
  if (line.find(';') != std::string_view::npos) return true;
  const std::vector<std::string_view> fields = SplitFields(line, ' ');
  return fields.size() > 1 && std::ranges::all_of(fields, [](std::string_view field) {
           return std::ranges::count(field, ',') <= 1 && !field.starts_with(',') &&
                  !field.ends_with(',');
         });
}

// Removes quotes and replaces decimal commas.
std::string PlainLine(std::string line) {
  std::erase(line, '"');
  if (HasDecimalCommas(line)) std::ranges::replace(line, ',', '.');
  return line;
}

std::string ReadTrajectoryText(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) throw IoError(path, "is a folder, not a file");
  if (!std::filesystem::exists(path)) {
    throw IoError(path, "cannot be opened: no such trajectory file, or not readable");
  }
  return ReadTextFile(path);
}

// Reads a file line by line, skipping empty lines and comments.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path)
      : path_(path), stream_(ReadTrajectoryText(path)) {}

  // Returns false at the end. The first line with values determines the separator.
  bool Next(Line* line) {
    while (std::getline(stream_, text_)) {
      ++line->number;
      text_ = PlainLine(std::move(text_));
      const std::string_view text = TrimmedBlanks(text_);
      if (text.empty()) continue;
      if (text.front() == '#' || text.front() == '%') {
        if (!separator_) headings_.emplace_back(text);
        continue;
      }
      if (!separator_ && IsHeading(text)) {
        headings_.emplace_back(text);
        if (!bare_heading_) bare_heading_ = *line;
        continue;
      }
      if (!separator_) separator_ = SeparatorOf(text);
      line->fields = SplitFields(text, *separator_);
      return true;
    }
    return false;
  }
  char separator() const { return separator_.value_or(' '); }
  // Lines before the first line with values.
  const std::vector<std::string>& headings() const { return headings_; }
  bool has_bare_heading() const { return bare_heading_.has_value(); }

  // A first line without # that names no column is not a heading but a damaged line.
  void RefuseBareHeading() const {
    if (!bare_heading_) return;
    Fail(*bare_heading_, "is neither a pose nor a heading that names tx ty tz qx qy qz qw");
  }
  [[noreturn]] void Fail(const Line& line, const std::string& what) const {
    throw IoError(path_, line.number, what);
  }
  double NumberAt(const Line& line, std::size_t column, std::string_view name) const {
    if (column >= line.fields.size()) {
      Fail(line, fmt::format("has {} values, too few for a pose", line.fields.size()));
    }
    const std::string_view text = line.fields[column];
    const std::optional<double> value = Number(text);
    if (!value) Fail(line, fmt::format("{} '{}' is not a number", name, text));
    if (!std::isfinite(*value)) {
      Fail(line, fmt::format("{} '{}' is not a finite number", name, text));
    }
    return *value;
  }

 private:
  static bool IsHeading(std::string_view text) {
    return std::ranges::none_of(SplitFields(text, SeparatorOf(text)),
                                [](std::string_view field) { return Number(field).has_value(); });
  }

  const std::filesystem::path& path_;
  TextReader stream_;
  std::string text_;
  std::optional<char> separator_;
  std::vector<std::string> headings_;
  std::optional<Line> bare_heading_;
};

// Layout of a table before its stamps are read.
struct Layout {
  TrajectoryColumns columns{};
  bool named = false;       // by a heading
  bool ros = false;         // by ROS's command line
  bool order_open = false;  // whether w comes first or last in the quaternion is unknown
  bool extra = false;       // columns after the pose, without a heading
};

// Layout of `ros2 topic echo --csv`, which has no heading: seconds, nanoseconds, one or two frame
// names.
std::optional<TrajectoryColumns> Ros2Columns(const Line& line) {
  const auto& fields = line.fields;
  if (fields.size() < 10 || !Number(fields[0]) || !Number(fields[1]) || Number(fields[2])) {
    return std::nullopt;
  }
  TrajectoryColumns columns{.nanoseconds = 1, .unit = kSecond};
  const std::size_t position = Number(fields[3]) ? 3 : 4;
  for (std::size_t i = 0; i < columns.pose.size(); ++i) columns.pose[i] = position + i;
  return columns;
}

std::optional<Layout> NamedLayout(const Reader& reader, const Line& line) {
  const auto& headings = reader.headings();
  for (auto heading = headings.rbegin(); heading != headings.rend(); ++heading) {
    auto columns = ColumnsByName(*heading, line.fields.size());
    const bool ros = heading->starts_with('%');
    if (!columns && ros) {
      reader.Fail(line,
                  "the title names no 'position.x' and 'orientation.x': expected poses as "
                  "rostopic echo -p prints them");
    }
    if (!columns) continue;
    if (ros && !columns->unit) columns->unit = kNanosecond;
    return Layout{.columns = *columns, .named = true, .ros = ros};
  }
  reader.RefuseBareHeading();
  return std::nullopt;
}

Layout LayoutOf(const Reader& reader, const Line& line) {
  if (const auto named = NamedLayout(reader, line)) return *named;
  const std::size_t width = line.fields.size();
  const bool table = reader.separator() != ' ';
  if (table) {
    if (const auto ros = Ros2Columns(line)) return {.columns = *ros, .ros = true};
  }
  if (width < 8) {
    reader.Fail(line, table ? fmt::format("has {} values, too few for a pose", width)
                            : fmt::format("expected the 8 numbers {}, found {} value{}",
                                          kTumColumns, width, width == 1 ? "" : "s"));
  }
  return {.order_open = table, .extra = width > 8};
}

// Values as in the file, until the unit of the stamps is known.
struct Row {
  std::int64_t line = 0;
  DecimalStamp stamp;
  std::array<double, 7> values{};  // in the order of TrajectoryColumns::pose
};

DecimalStamp StampAt(const Reader& reader, const Line& line, const TrajectoryColumns& columns) {
  reader.NumberAt(line, columns.stamp, "the stamp");
  const std::string_view text = line.fields[columns.stamp];
  std::optional<DecimalStamp> stamp = ParseDecimalStamp(text);
  if (!columns.nanoseconds) {
    if (!stamp) reader.Fail(line, fmt::format("'{}' is no stamp", text));
    return *stamp;
  }
  const double part = reader.NumberAt(line, *columns.nanoseconds, "the stamp");
  if (!stamp || !ToStamp(*stamp, kSecond) || part < 0.0 || part >= 1e9) {
    reader.Fail(line, fmt::format("'{}' is no stamp in seconds and nanoseconds", text));
  }
  stamp->billionths = static_cast<std::uint64_t>(part);
  return *stamp;
}

Row RowOf(const Reader& reader, const Line& line, const TrajectoryColumns& columns) {
  Row row{.line = line.number, .stamp = StampAt(reader, line, columns)};
  for (std::size_t i = 0; i < row.values.size(); ++i) {
    row.values[i] = reader.NumberAt(line, columns.pose[i], kPoseNames[i]);
  }
  const double norm = Eigen::Map<const Eigen::Vector4d>(row.values.data() + 3).norm();
  if (norm < 1e-6) reader.Fail(line, "the quaternion is zero, which is no rotation");
  if (!std::isfinite(norm)) reader.Fail(line, "the quaternion is too large to normalise");
  return row;
}

std::vector<Row> ReadRows(Reader& reader, Line line, const TrajectoryColumns& columns) {
  const std::size_t width = line.fields.size();
  std::vector<Row> rows;
  do {
    const std::size_t found = line.fields.size();
    if (reader.separator() != ' ' && found == 1) {
      reader.Fail(line, fmt::format("expected values separated by {}",
                                    reader.separator() == ',' ? "commas" : "semicolons"));
    }
    if (reader.separator() == ' ' && found != width) {
      reader.Fail(line,
                  fmt::format("expected {}, found {} value{}",
                              width == 8 ? fmt::format("the 8 numbers {}", kTumColumns)
                                         : fmt::format("{} values as in the lines before", width),
                              found, found == 1 ? "" : "s"));
    }
    rows.push_back(RowOf(reader, line, columns));
  } while (reader.Next(&line));
  return rows;
}

// Numbers without a heading are ambiguous: a matrix after a stamp, a quaternion before its
// position. The TUM format needs no heading, and its quaternions may have any length.
void RequireUnitQuaternions(const Reader& reader, const Layout& layout,
                            const std::vector<Row>& rows) {
  if (layout.named || layout.ros) return;
  const auto unit = [](std::size_t first) {
    return [first](const Row& row) {
      const double norm = Eigen::Map<const Eigen::Vector4d>(row.values.data() + first).norm();
      return std::abs(norm - 1.0) <= 0.01;
    };
  };
  const auto other = std::ranges::find_if_not(rows, unit(3));
  const bool free_form = layout.order_open || layout.extra;
  if (other == rows.end() || !(free_form || std::ranges::all_of(rows, unit(0)))) return;
  reader.Fail({.number = other->line, .fields = {}},
              "its values 5 to 8 are no unit quaternion: write a heading that names the columns, "
              "such as 'stamp tx ty tz qx qy qz qw'");
}

std::string NameOfUnit(std::int64_t unit) {
  if (unit == kSecond) return "seconds";
  if (unit == kMillisecond) return "milliseconds";
  return unit == kMicrosecond ? "microseconds" : "nanoseconds";
}

// Returns the unit of stamps that the heading does not specify. Adds to `assumed` if the values are
// inconclusive.
std::int64_t UnitOfStamps(const Layout& layout, const std::vector<Row>& rows, bool table,
                          std::vector<std::string>* assumed) {
  std::vector<double> stamps;
  for (const Row& row : rows) stamps.push_back(ToDouble(row.stamp));
  const std::optional<std::int64_t> named = layout.columns.unit;
  if (named && (layout.ros || IsPossibleUnit(stamps, *named))) return *named;
  const TimeUnit guess = GuessTimeUnit(stamps, table);
  if (named || !guess.sure) assumed->push_back("stamps in " + NameOfUnit(guess.nanoseconds));
  return guess.nanoseconds;
}

// Whether w comes first in a quaternion without a heading: from a first pose without rotation,
// otherwise as in EuRoC for nanoseconds and last for other tables.
bool IsScalarFirst(const std::vector<Row>& rows, std::int64_t unit) {
  const std::array<double, 7>& first = rows.front().values;
  const bool turned = first[4] != 0.0 || first[5] != 0.0;
  if (!turned && first[6] == 0.0) return true;
  if (!turned && first[3] == 0.0) return false;
  return unit == kNanosecond;
}

TrajectoryFormat FormatOf(const Reader& reader, const Layout& layout, std::int64_t unit,
                          std::size_t width) {
  if (layout.ros) return TrajectoryFormat::kRos;
  const TrajectoryColumns& columns = layout.columns;
  if (reader.has_bare_heading() || columns.stamp != 0) return TrajectoryFormat::kTable;
  if (reader.separator() == ' ' && unit == kSecond && width == 8 &&
      columns.pose == TrajectoryColumns().pose) {
    return TrajectoryFormat::kTum;
  }
  if (reader.separator() == ',' && unit == kNanosecond && columns.pose == kScalarFirst) {
    return TrajectoryFormat::kEuroc;
  }
  return TrajectoryFormat::kTable;
}

void AddPoses(const Reader& reader, const std::vector<Row>& rows, std::int64_t unit,
              TrajectoryFile* file) {
  for (const Row& row : rows) {
    const Line line{.number = row.line, .fields = {}};
    const std::optional<Stamp> stamp = ToStamp(row.stamp, unit);
    if (!stamp) reader.Fail(line, fmt::format("the stamp is no time in {}", NameOfUnit(unit)));
    if (!file->poses.empty() && *stamp < file->poses.back().stamp) {
      reader.Fail(line, fmt::format("the stamp goes back in time, to {} s behind {} s: sort the "
                                    "lines by their stamps",
                                    FormatStamp(*stamp), FormatStamp(file->poses.back().stamp)));
    }
    file->poses.push_back({*stamp, Pose::FromBlock(row.values.data())});
    file->lines.push_back(row.line);
  }
}

TrajectoryFile ReadTable(Reader& reader, const Line& line) {
  Layout layout = LayoutOf(reader, line);
  const std::size_t width = line.fields.size();
  const bool table = reader.separator() != ' ';
  std::vector<Row> rows = ReadRows(reader, line, layout.columns);
  RequireUnitQuaternions(reader, layout, rows);
  std::vector<std::string> assumed;
  const std::int64_t unit = UnitOfStamps(layout, rows, table, &assumed);
  if (layout.order_open) {
    const bool ground_truth = unit == kNanosecond && width == 17;  // EuRoC's, without its heading
    const bool w_first = ground_truth || IsScalarFirst(rows, unit);
    if (assumed.empty() && !ground_truth) assumed.push_back("stamps in " + NameOfUnit(unit));
    if (!ground_truth) {
      assumed.push_back(w_first ? "quaternions as w x y z" : "quaternions as x y z w");
    }
    if (w_first) {
      layout.columns.pose = kScalarFirst;
      for (Row& row : rows) std::rotate(&row.values[3], &row.values[4], &row.values[7]);
    }
  } else if (layout.extra) {
    assumed.push_back("its first 8 columns as stamp tx ty tz qx qy qz qw");
  }
  TrajectoryFile file{.format = FormatOf(reader, layout, unit, width)};
  AddPoses(reader, rows, unit, &file);
  if (!assumed.empty()) {
    file.assumed = fmt::format("read with {}, which no heading says", fmt::join(assumed, " and "));
  }
  return file;
}

std::optional<Pose> PoseOfMatrix(const Reader& reader, const Line& line) {
  Eigen::Matrix<double, 3, 4> T;
  for (int i = 0; i < 12; ++i) {
    T(i / 4, i % 4) = reader.NumberAt(line, static_cast<std::size_t>(i), "the matrix's");
  }
  const Eigen::Matrix3d R = T.leftCols<3>();
  // Files typically have about six digits.
  const bool rotation =
      (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() <= 1e-2 && R.determinant() > 0.0;
  if (!rotation) return std::nullopt;
  return Pose(Eigen::Quaterniond(R).normalized(), T.col(3));
}

// The last row of 16 numbers identifies a matrix; 12 numbers are one if blanks separate them.
bool HoldsMatrix(const Reader& reader, const Line& line) {
  const auto& fields = line.fields;
  if (fields.size() == 12) {
    const bool numbers = std::ranges::all_of(fields, [](auto f) { return Number(f).has_value(); });
    return reader.separator() == ' ' || (numbers && PoseOfMatrix(reader, line));
  }
  return fields.size() == 16 && Number(fields[12]) == 0.0 && Number(fields[13]) == 0.0 &&
         Number(fields[14]) == 0.0 && Number(fields[15]) == 1.0;
}

TrajectoryFile ReadMatrices(Reader& reader, Line line) {
  const std::size_t width = line.fields.size();
  TrajectoryFile file{.format =
                          width == 12 ? TrajectoryFormat::kKitti : TrajectoryFormat::kMatrices};
  do {
    if (line.fields.size() != width) {
      reader.Fail(line, fmt::format("expected the {} numbers of a {} x 4 matrix, found {}", width,
                                    width / 4, line.fields.size()));
    }
    const std::optional<Pose> pose = PoseOfMatrix(reader, line);
    if (!pose) reader.Fail(line, "the first 3 x 3 numbers are no rotation");
    if (width == 16 && !HoldsMatrix(reader, line)) {
      reader.Fail(line, "the last row of the matrix is not 0 0 0 1");
    }
    file.poses.push_back({FromSeconds(static_cast<double>(file.poses.size())), *pose});
    file.lines.push_back(line.number);
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
    case TrajectoryFormat::kMatrices:
      return "matrices";
    case TrajectoryFormat::kEuroc:
      return "euroc";
    case TrajectoryFormat::kRos:
      return "ros";
    case TrajectoryFormat::kTable:
      return "table";
  }
  return "tum";
}

bool HasStamps(TrajectoryFormat format) {
  return format != TrajectoryFormat::kKitti && format != TrajectoryFormat::kMatrices;
}

TrajectoryFile ReadTrajectoryFile(const std::filesystem::path& path) {
  Reader reader(path);
  Line line;
  if (!reader.Next(&line)) {
    reader.RefuseBareHeading();
    return {};
  }
  const auto named = std::ranges::any_of(reader.headings(), [&](const std::string& heading) {
    return ColumnsByName(heading, line.fields.size()).has_value();
  });
  if (!named && HoldsMatrix(reader, line)) return ReadMatrices(reader, std::move(line));
  return ReadTable(reader, line);
}

void RequireDistinctStamps(const std::filesystem::path& path, TrajectoryFile* file) {
  constexpr std::size_t kOften = 1000;
  TrajectoryFile distinct{.format = file->format, .assumed = file->assumed};
  std::optional<std::int64_t> first;
  for (std::size_t i = 0; i < file->poses.size(); ++i) {
    if (i > 0 && file->poses[i].stamp == file->poses[i - 1].stamp) {
      if (!first) first = file->lines[i];
      continue;
    }
    distinct.poses.push_back(file->poses[i]);
    distinct.lines.push_back(file->lines[i]);
  }
  if (!first) return;
  const std::size_t left_out = file->poses.size() - distinct.poses.size();
  if (left_out * kOften > file->poses.size()) {
    throw IoError(path, *first,
                  fmt::format("has the stamp of the pose before it, as {} of {} do: write stamps "
                              "with more digits, and each pose once",
                              left_out, file->poses.size()));
  }
  const std::string what = fmt::format(
      "left out {} of {} poses, which have the stamp of the pose before them, the first in line {}",
      left_out, file->poses.size(), *first);
  distinct.assumed += (distinct.assumed.empty() ? "" : "; ") + what;
  *file = std::move(distinct);
}

}  // namespace highwall::apps
