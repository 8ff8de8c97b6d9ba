// IMU preintegration against the ground truth of a EuRoC sequence: from the true state at the start
// of a window it predicts the state at its end. Prints the median errors, and the squared error
// normalised by the predicted 9 x 9 covariance (1 where the noise model tells all).
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/imu_preintegration.h>

namespace highwall {
namespace {

struct TrueState {
  Stamp stamp = 0;
  ImuState state;
  ImuBias bias;
};

// A line of a EuRoC file: a stamp in nanoseconds, then `count` numbers.
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

ImuBuffer ReadImu(const std::filesystem::path& path) {
  ImuBuffer buffer({.max_step = 0.1, .horizon = 1e6});
  for (const Row& row : ReadCsv(path, 6)) {
    const auto& v = row.values;
    buffer.Add({row.stamp, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
  }
  if (buffer.empty()) throw IoError(path, "holds no readings");
  return buffer;
}

std::vector<TrueState> ReadGroundTruth(const std::filesystem::path& path) {
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

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Errors {
  std::vector<double> rotation_deg, velocity, position, motion, normalised;
  int skipped = 0;  // windows with a gap, or beyond the readings

  void Add(const ImuPreintegration& imu, const TrueState& from, const TrueState& to) {
    const Eigen::Vector3d gravity_W(0.0, 0.0, -kStandardGravity);
    const ImuState predicted = imu.Predict(from.state, from.bias, gravity_W);
    const Eigen::Quaterniond q_BW = from.state.T_WB.q().conjugate();
    // As the residual of ImuFactor: velocity and position in the frame of the start.
    Eigen::Matrix<double, 9, 1> e;
    e << so3::Log(predicted.T_WB.q().conjugate() * to.state.T_WB.q()),
        q_BW * (to.state.v_WB - predicted.v_WB), q_BW * (to.state.T_WB.p() - predicted.T_WB.p());
    rotation_deg.push_back(e.head<3>().norm() * 180.0 / M_PI);
    velocity.push_back(e.segment<3>(3).norm());
    position.push_back(e.tail<3>().norm());
    motion.push_back((to.state.T_WB.p() - from.state.T_WB.p()).norm());
    const Eigen::Matrix<double, 9, 9> P = imu.covariance().topLeftCorner<9, 9>();
    normalised.push_back(e.dot(P.llt().solve(e)) / 9.0);
  }
};

nlohmann::json Run(const std::filesystem::path& folder, double window) {
  const ImuBuffer imu = ReadImu(folder / "imu.csv");
  const std::vector<TrueState> truth = ReadGroundTruth(folder / "groundtruth.csv");
  Errors errors;
  for (std::size_t i = 0; i < truth.size();) {
    std::size_t j = i + 1;
    while (j < truth.size() && ToSeconds(truth[j].stamp - truth[i].stamp) < window - 1e-3) ++j;
    if (j == truth.size()) break;
    const auto interval = imu.Between(truth[i].stamp, truth[j].stamp);
    if (interval && !interval->HasGap()) {
      errors.Add(ImuPreintegration(interval->samples, truth[i].bias), truth[i], truth[j]);
    } else {
      ++errors.skipped;
    }
    i = j;
  }
  if (errors.position.empty()) throw IoError(folder, "no window has both readings and states");
  return {{"windows", errors.position.size()},
          {"skipped", errors.skipped},
          {"window_s", window},
          {"median_motion_m", Median(errors.motion)},
          {"median_rotation_deg", Median(errors.rotation_deg)},
          {"median_velocity_m_s", Median(errors.velocity)},
          {"median_position_m", Median(errors.position)},
          {"median_normalised_error", Median(errors.normalised)}};
}

}  // namespace
}  // namespace highwall

int main(int argc, char** argv) {
  CLI::App app{
      "IMU preintegration against the ground truth of a EuRoC sequence.\nExample: "
      "highwall_bench_imu --data ../shared/data/euroc_v101 --json"};
  std::string data;
  double window = 0.5;
  bool json = false;
  app.add_option("--data", data, "Folder with imu.csv and groundtruth.csv")->required();
  app.add_option("--window", window, "Length of a prediction [s]")->check(CLI::PositiveNumber);
  app.add_flag("--json", json, "One JSON object on standard output");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  }
  try {
    const nlohmann::json report = highwall::Run(data, window);
    if (json) {
      std::printf("%s\n", report.dump().c_str());
    } else {
      for (const auto& [key, value] : report.items()) {
        std::printf("%-26s %s\n", key.c_str(), value.dump().c_str());
      }
    }
  } catch (const highwall::IoError& error) {
    std::fprintf(stderr, "highwall_bench_imu: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "highwall_bench_imu: %s\n", error.what());
    return 3;
  }
  return 0;
}
