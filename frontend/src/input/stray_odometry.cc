#include "input/stray_odometry.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/text_file.h>

namespace highwall {
namespace {

constexpr std::array<std::string_view, 13> kOdometryNames{
    "timestamp", "frame", "x", "y", "z", "qx", "qy", "qz", "qw", "fx", "fy", "cx", "cy"};
constexpr std::size_t kPoseNames = 9;  // of these every line has

// Where the values of a line are, by the indices of kOdometryNames.
struct OdometryColumns {
  std::array<std::size_t, kOdometryNames.size()> at{0, 1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 0};
  bool with_intrinsics = false;
};

OdometryColumns FindOdometryColumns(const std::filesystem::path& path, std::int64_t line,
                                    std::span<const std::string_view> heading) {
  OdometryColumns columns;
  std::size_t found = 0;
  for (std::size_t i = 0; i < kOdometryNames.size(); ++i) {
    const auto name = std::ranges::find(heading, kOdometryNames[i]);
    if (name == heading.end()) {
      if (i >= kPoseNames) break;
      throw IoError(path, line, "names no column '" + std::string(kOdometryNames[i]) + "'");
    }
    columns.at[i] = static_cast<std::size_t>(name - heading.begin());
    ++found;
  }
  columns.with_intrinsics = found == kOdometryNames.size();
  return columns;
}

// Parses the values from x on.
double OdometryValue(const std::filesystem::path& path, std::int64_t line, std::string_view word) {
  const std::optional<double> value = ReadNumber<double>(word);
  if (value && std::isfinite(*value)) return *value;
  throw IoError(path, line, "'" + std::string(word) + "' is not a finite number");
}

StrayPose ParseOdometry(const std::filesystem::path& path, std::int64_t line,
                        const std::vector<std::string_view>& words,
                        const OdometryColumns& columns) {
  const std::size_t names = columns.with_intrinsics ? kOdometryNames.size() : kPoseNames;
  const std::size_t last = *std::max_element(columns.at.begin(), columns.at.begin() + names);
  if (words.size() <= last) {
    throw IoError(path, line,
                  "has " + std::to_string(words.size()) + " of the " + std::to_string(last + 1) +
                      " values timestamp, frame, x, y, z, qx, qy, qz, qw");
  }
  StrayPose pose;
  const std::optional<Stamp> stamp = ParseStamp(words[columns.at[0]]);
  const std::optional<std::int64_t> frame = ReadNumber<std::int64_t>(words[columns.at[1]]);
  if (!stamp) throw IoError(path, line, "does not begin with a time in seconds");
  if (!frame || *frame < 0) throw IoError(path, line, "has no number of a frame");
  std::array<double, kOdometryNames.size()> v{};
  for (std::size_t i = 2; i < names; ++i) v[i] = OdometryValue(path, line, words[columns.at[i]]);
  const Eigen::Quaterniond q(v[8], v[5], v[6], v[7]);
  if (!(q.norm() > 1e-6) || !std::isfinite(q.norm())) {
    throw IoError(path, line, "its quaternion is zero or not finite");
  }
  pose.stamp = *stamp;
  pose.frame = *frame;
  pose.T_WC = Pose(q, {v[2], v[3], v[4]});
  if (!columns.with_intrinsics) return pose;
  if (!(v[9] > 0.0) || !(v[10] > 0.0)) throw IoError(path, line, "fx and fy must be positive");
  pose.intrinsics = {v[9], v[10], v[11], v[12]};
  return pose;
}

}  // namespace

std::vector<StrayPose> ReadStrayOdometry(const std::filesystem::path& path) {
  TextReader file(ReadTextFile(path));
  std::vector<StrayPose> poses;
  OdometryColumns columns;
  bool first = true;
  std::string line;
  for (std::int64_t number = 1; std::getline(file, line); ++number) {
    const std::vector<std::string_view> words = SplitWords(line, ", \t\r");
    if (words.empty()) continue;
    const bool heading = first && std::isalpha(static_cast<unsigned char>(words[0][0])) != 0;
    first = false;
    if (heading) {
      columns = FindOdometryColumns(path, number, words);
    } else {
      poses.push_back(ParseOdometry(path, number, words, columns));
    }
  }
  if (poses.empty()) throw IoError(path, "holds no pose");
  return poses;
}

}  // namespace highwall
