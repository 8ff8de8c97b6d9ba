#include <highwall/core/trajectory.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/core/trajectory_log.h>
#include <highwall/internal/number_text.h>

namespace highwall {
namespace {

constexpr std::array<const char*, 8> kColumns = {"stamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};
constexpr std::string_view kBlanks = " \t\r";
constexpr std::string_view kTitle = "# stamp tx ty tz qx qy qz qw\n";

// One line of a TUM file, with path and line number for the messages.
struct TrajectoryLine {
  const std::filesystem::path& path;
  std::int64_t number;
  std::string_view text;

  [[noreturn]] void Fail(const std::string& what) const { throw IoError(path, number, what); }
};

double ParseFinite(const TrajectoryLine& line, const char* column, std::string_view text) {
  const std::string_view digits = text.starts_with('+') ? text.substr(1) : text;
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const std::string quoted = "'" + std::string(text) + "'";
  if (error == std::errc::invalid_argument || end != digits.data() + digits.size()) {
    line.Fail(std::string(column) + " " + quoted + " is not a number");
  }
  if (error != std::errc() || !std::isfinite(value)) {
    line.Fail(std::string(column) + " " + quoted + " is not a finite number");
  }
  return value;
}

StampedPose ParseStampedPose(const TrajectoryLine& line) {
  const std::vector<std::string_view> columns = SplitWords(line.text, kBlanks);
  if (columns.size() != kColumns.size()) {
    line.Fail("expected the 8 numbers 'stamp tx ty tz qx qy qz qw' separated by blanks, found " +
              std::to_string(columns.size()) + (columns.size() == 1 ? " value" : " values"));
  }
  const std::optional<Stamp> stamp = ParseStamp(columns[0]);
  if (!stamp) line.Fail("stamp '" + std::string(columns[0]) + "' is not a time in seconds");
  std::array<double, Pose::kSize> block;
  for (std::size_t i = 0; i < block.size(); ++i) {
    block[i] = ParseFinite(line, kColumns[i + 1], columns[i + 1]);
  }
  const Eigen::Map<const Eigen::Quaterniond> q(block.data() + 3);
  if (q.norm() < 1e-6) line.Fail("the quaternion qx qy qz qw is zero, which is no rotation");
  if (!std::isfinite(q.norm())) line.Fail("the quaternion qx qy qz qw is too large to normalise");
  return {*stamp, Pose::FromBlock(block.data())};
}

bool StampsDoNotDecrease(const Trajectory& trajectory) {
  return std::is_sorted(
      trajectory.begin(), trajectory.end(),
      [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
}

// Returns the first pose whose stamp is not smaller.
Trajectory::const_iterator LowerBound(const Trajectory& trajectory, Stamp stamp) {
  return std::lower_bound(trajectory.begin(), trajectory.end(), stamp,
                          [](const StampedPose& a, Stamp b) { return a.stamp < b; });
}

// Correctly rounded, unlike ToSeconds, which rounds twice: the figures of evo depend on it where a
// stamp lies halfway between two others.
double UnixSeconds(Stamp stamp) {
  constexpr Stamp kSecond = 1'000'000'000;
  return static_cast<double>(stamp / kSecond) + static_cast<double>(stamp % kSecond) / 1e9;
}

double Distance(Stamp a, Stamp b) {
  return std::abs(UnixSeconds(a) - UnixSeconds(b));
}

// Returns the first pose with the nearest stamp. The trajectory must not be empty.
std::size_t NearestIndex(const Trajectory& trajectory, Stamp stamp) {
  auto nearest = LowerBound(trajectory, stamp);
  if (nearest != trajectory.begin()) {
    const auto before = std::prev(nearest);
    if (nearest == trajectory.end() ||
        Distance(before->stamp, stamp) <= Distance(nearest->stamp, stamp)) {
      nearest = LowerBound(trajectory, before->stamp);
    }
  }
  return static_cast<std::size_t>(nearest - trajectory.begin());
}

// Includes the end of the line.
std::string FormatLine(const StampedPose& stamped) {
  HIGHWALL_REQUIRE(stamped.pose.IsFinite(),
                   "the pose at stamp " + FormatStamp(stamped.stamp) + " is not finite");
  std::string line = FormatStamp(stamped.stamp);
  // Ten decimals: rounding each of four to 1e-9 may cost 1.5e-9 once they are normalised.
  for (int i = 0; i < Pose::kSize; ++i) {
    line += ' ' + FixedText(stamped.pose.data()[i], 10);
  }
  return line + '\n';
}

}  // namespace

Trajectory ReadTumTrajectory(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) {
    throw IoError(path, "is a folder; expected a trajectory file in the TUM form");
  }
  std::ifstream file(path);
  if (!file) throw IoError(path, "cannot be opened: no such trajectory file, or not readable");
  Trajectory trajectory;
  std::string text;
  for (std::int64_t number = 1; std::getline(file, text); ++number) {
    const std::size_t begin = text.find_first_not_of(kBlanks);
    if (begin == std::string::npos || text[begin] == '#') continue;
    const TrajectoryLine line{path, number, text};
    const StampedPose pose = ParseStampedPose(line);
    if (!trajectory.empty() && pose.stamp < trajectory.back().stamp) {
      line.Fail("stamp " + FormatStamp(pose.stamp) + " goes back in time, behind " +
                FormatStamp(trajectory.back().stamp) + ": sort the lines by their stamps");
    }
    trajectory.push_back(pose);
  }
  if (file.bad()) throw IoError(path, "could not be read to its end");
  return trajectory;
}

void WriteTumTrajectory(const std::filesystem::path& path, const Trajectory& trajectory) {
  HIGHWALL_REQUIRE(StampsDoNotDecrease(trajectory), "the stamps of a trajectory must not decrease");
  AtomicFile file(path);
  file.stream() << kTitle;
  for (const StampedPose& stamped : trajectory) file.stream() << FormatLine(stamped);
  file.Commit();
}

TrajectoryLog::TrajectoryLog(const std::filesystem::path& path) : path_(path) {
  errno = 0;
  stream_.open(path, std::ios::binary | std::ios::trunc);
  Put(kTitle);
}

void TrajectoryLog::Append(const StampedPose& pose) {
  HIGHWALL_REQUIRE(!last_ || pose.stamp >= *last_, "the stamps of a trajectory must not decrease");
  const std::string line = FormatLine(pose);
  last_ = pose.stamp;
  errno = 0;
  Put(line);
}

void TrajectoryLog::Put(std::string_view text) {
  stream_ << text << std::flush;
  if (stream_) {
    size_ += text.size();
    return;
  }
  const std::string reason = std::strerror(errno);
  std::error_code ignored;
  std::filesystem::resize_file(path_, size_, ignored);
  throw IoError(path_, "could not be written: " + reason);
}

std::vector<StampMatch> MatchByStamp(const Trajectory& reference, const Trajectory& estimate,
                                     Stamp tolerance) {
  HIGHWALL_REQUIRE(StampsDoNotDecrease(reference) && StampsDoNotDecrease(estimate),
                   "the stamps of a trajectory must not decrease");
  HIGHWALL_REQUIRE(tolerance >= 0, "the tolerance must not be negative");
  const bool reference_is_shorter = reference.size() < estimate.size();
  const Trajectory& shorter = reference_is_shorter ? reference : estimate;
  const Trajectory& longer = reference_is_shorter ? estimate : reference;
  std::vector<StampMatch> matches;
  for (std::size_t i = 0; i < shorter.size(); ++i) {
    const std::size_t j = NearestIndex(longer, shorter[i].stamp);
    if (std::abs(longer[j].stamp - shorter[i].stamp) > tolerance) continue;
    matches.push_back(reference_is_shorter ? StampMatch{i, j} : StampMatch{j, i});
  }
  return matches;
}

std::optional<Pose> Interpolate(const Trajectory& trajectory, Stamp stamp) {
  const auto after = LowerBound(trajectory, stamp);
  if (after == trajectory.end()) return std::nullopt;
  if (after->stamp == stamp) return after->pose;
  if (after == trajectory.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double ratio = static_cast<double>(stamp - before->stamp) /
                       static_cast<double>(after->stamp - before->stamp);
  return Pose(before->pose.q().slerp(ratio, after->pose.q()),
              before->pose.p() + ratio * (after->pose.p() - before->pose.p()));
}

}  // namespace highwall
