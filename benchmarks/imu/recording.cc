#include "recording.h"

#include <charconv>
#include <cstdint>
#include <fstream>
#include <string>

#include <highwall/core/error.h>
#include <highwall/core/trajectory.h>

namespace highwall::bench {
namespace {

// Line of a EuRoC file: a stamp in nanoseconds, then `count` numbers.
struct Row {
  Stamp stamp = 0;
  std::vector<double> values;
};

std::vector<Row> ReadCsv(const std::filesystem::path& path, std::size_t count) {
  std::ifstream stream(path);
  if (!stream) throw IoError(path, "cannot be read");
  std::vector<Row> rows;
  std::string line;
  for (std::int64_t number = 1; std::getline(stream, line); ++number) {
    if (line.empty() || line.front() == '#') continue;
    Row row;
    const char* at = line.data();
    const char* const end = at + line.size();
    auto result = std::from_chars(at, end, row.stamp);
    while (result.ec == std::errc() && result.ptr != end && *result.ptr == ',') {
      row.values.emplace_back();
      result = std::from_chars(result.ptr + 1, end, row.values.back());
    }
    if (result.ec != std::errc() || row.values.size() != count) {
      throw IoError(path, number, "expected a stamp and " + std::to_string(count) + " numbers");
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

ImuBuffer ReadReadings(const std::filesystem::path& path) {
  ImuBuffer buffer({.max_step = 0.1, .horizon = 1e6});
  for (const Row& row : ReadCsv(path, 6)) {
    const auto& v = row.values;
    buffer.Add({row.stamp, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
  }
  if (buffer.empty()) throw IoError(path, "holds no readings");
  return buffer;
}

std::vector<TrueState> ReadEurocTruth(const std::filesystem::path& path) {
  std::vector<TrueState> states;
  for (const Row& row : ReadCsv(path, 16)) {
    const auto& v = row.values;
    TrueState truth;
    truth.stamp = row.stamp;
    truth.state = {Pose(Eigen::Quaterniond(v[3], v[4], v[5], v[6]), {v[0], v[1], v[2]}),
                   {v[7], v[8], v[9]}};
    truth.bias << v[10], v[11], v[12], v[13], v[14], v[15];
    states.push_back(truth);
  }
  return states;
}

// Velocities are least-squares slopes of the positions within 50 ms; poses whose interval reaches
// the first or the last pose are skipped.
std::vector<TrueState> ReadPoses(const std::filesystem::path& path) {
  constexpr double kHalfWidth = 0.05;  // [s]
  const Trajectory poses = ReadTumTrajectory(path);
  std::vector<TrueState> states;
  std::size_t begin = 0, end = 0;
  for (const StampedPose& at : poses) {
    const auto seconds = [&](std::size_t i) { return ToSeconds(poses[i].stamp - at.stamp); };
    while (seconds(begin) < -kHalfWidth) ++begin;
    while (end < poses.size() && seconds(end) <= kHalfWidth) ++end;
    if (begin == 0 || end == poses.size()) continue;
    double sum = 0.0, squares = 0.0;
    const auto count = static_cast<double>(end - begin);
    Eigen::Vector3d positions = Eigen::Vector3d::Zero(), products = Eigen::Vector3d::Zero();
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Vector3d p = poses[i].pose.p() - at.pose.p();
      sum += seconds(i);
      squares += seconds(i) * seconds(i);
      positions += p;
      products += seconds(i) * p;
    }
    const double spread = squares - sum * sum / count;
    if (spread <= 0.0) continue;
    TrueState truth;
    truth.stamp = at.stamp;
    truth.state = {at.pose, (products - sum / count * positions) / spread};
    states.push_back(truth);
  }
  return states;
}

}  // namespace

Recording ReadRecording(const std::filesystem::path& folder) {
  const std::filesystem::path poses = folder / "groundtruth.txt";
  const bool has_biases = !std::filesystem::exists(poses);
  return {.imu = ReadReadings(folder / "imu.csv"),
          .truth = has_biases ? ReadEurocTruth(folder / "groundtruth.csv") : ReadPoses(poses),
          .has_biases = has_biases};
}

}  // namespace highwall::bench
