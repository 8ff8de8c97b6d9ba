// IMU preintegration against the ground truth of a EuRoC sequence: from the true state at the start
// of a window it predicts the state at its end. Prints the median errors, and the squared errors
// normalised by the predicted covariance (about 1 where the noise of the IMU is all there is; the
// errors of the ground truth come on top). Twice: with gravity along -z, and with its direction
// estimated from the sequence, since a frame of ground truth may be tilted.
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/App.hpp>
#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/so3.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/imu_preintegration.h>

#include "bench_main.h"
#include "medians.h"

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

struct Window {
  ImuPreintegration imu;
  TrueState from, to;
};

struct Windows {
  std::vector<Window> all;
  int skipped = 0;  // with a gap, or beyond the readings
};

Windows Cut(const ImuBuffer& imu, const std::vector<TrueState>& truth, double length) {
  constexpr double kTolerance = 1e-3;  // [s] of the stamps
  Windows windows;
  for (std::size_t i = 0; i < truth.size();) {
    std::size_t j = i + 1;
    while (j < truth.size() && ToSeconds(truth[j].stamp - truth[i].stamp) < length - kTolerance) {
      ++j;
    }
    if (j == truth.size()) break;
    const auto interval = imu.Between(truth[i].stamp, truth[j].stamp);
    if (interval && !interval->HasGap()) {
      windows.all.push_back(
          {ImuPreintegration(interval->samples, truth[i].bias), truth[i], truth[j]});
    } else {
      ++windows.skipped;
    }
    i = j;
  }
  return windows;
}

// The direction of gravity that fits all windows best, the true states being known.
Eigen::Vector3d EstimateGravity(const std::vector<Window>& windows) {
  FactorGraph graph;
  const auto known = [&graph](const auto& value) {
    const auto variable = graph.AddVariable(value);
    graph.Fix(variable);
    return variable;
  };
  const auto direction = graph.AddVariable(UnitDirection());
  for (const Window& w : windows) {
    graph.AddFactor(std::make_unique<ImuGravityFactor>(w.imu), known(w.from.state.T_WB),
                    known(w.from.state.v_WB), known(w.from.bias), known(w.to.state.T_WB),
                    known(w.to.state.v_WB), known(w.to.bias), direction);
  }
  graph.Solve();
  return kStandardGravity * graph.Value(direction).vector();
}

nlohmann::json Errors(const std::vector<Window>& windows, const Eigen::Vector3d& gravity_W) {
  std::vector<double> rotation_deg, velocity, position, normalised[3];
  for (const Window& w : windows) {
    const ImuState predicted = w.imu.Predict(w.from.state, w.from.bias, gravity_W);
    const Eigen::Quaterniond q_BW = w.from.state.T_WB.q().conjugate();
    // As the residual of ImuFactor: velocity and position in the frame of the start.
    Eigen::Matrix<double, 9, 1> e;
    e << so3::Log(predicted.T_WB.q().conjugate() * w.to.state.T_WB.q()),
        q_BW * (w.to.state.v_WB - predicted.v_WB),
        q_BW * (w.to.state.T_WB.p() - predicted.T_WB.p());
    rotation_deg.push_back(e.head<3>().norm() * 180.0 / M_PI);
    velocity.push_back(e.segment<3>(3).norm());
    position.push_back(e.tail<3>().norm());
    for (int i = 0; i < 3; ++i) {
      const Eigen::Matrix3d P = w.imu.covariance().block<3, 3>(3 * i, 3 * i);
      const Eigen::Vector3d part = e.segment<3>(3 * i);
      normalised[i].push_back(part.dot(P.llt().solve(part)) / 3.0);
    }
  }
  return {{"rotation_deg", bench::Median(rotation_deg)},
          {"velocity_m_s", bench::Median(velocity)},
          {"position_m", bench::Median(position)},
          {"normalised_rotation", bench::Median(normalised[0])},
          {"normalised_velocity", bench::Median(normalised[1])},
          {"normalised_position", bench::Median(normalised[2])}};
}

nlohmann::json Run(const std::filesystem::path& folder, double length) {
  const Windows windows =
      Cut(ReadImu(folder / "imu.csv"), ReadGroundTruth(folder / "groundtruth.csv"), length);
  if (windows.all.empty()) throw IoError(folder, "no window has both readings and states");
  std::vector<double> motion;
  for (const Window& w : windows.all) {
    motion.push_back((w.to.state.T_WB.p() - w.from.state.T_WB.p()).norm());
  }
  const Eigen::Vector3d down(0.0, 0.0, -kStandardGravity);
  const Eigen::Vector3d gravity_W = EstimateGravity(windows.all);
  return {{"windows", windows.all.size()},
          {"skipped", windows.skipped},
          {"window_s", length},
          {"median_motion_m", bench::Median(motion)},
          {"median_errors", Errors(windows.all, down)},
          {"gravity_tilt_deg",
           std::atan2(down.cross(gravity_W).norm(), down.dot(gravity_W)) * 180.0 / M_PI},
          {"median_errors_gravity_estimated", Errors(windows.all, gravity_W)}};
}

}  // namespace
}  // namespace highwall

int main(int argc, char** argv) {
  CLI::App app(
      "IMU preintegration against the ground truth of a EuRoC sequence.\nExample: "
      "highwall_bench_imu --data ../shared/data/euroc_v101 --json",
      "highwall_bench_imu");
  std::string data;
  double window = 0.5;
  bool json = false;
  app.add_option("--data", data, "Folder with imu.csv and groundtruth.csv")->required();
  app.add_option("--window", window, "Length of a prediction [s]")->check(CLI::PositiveNumber);
  app.add_flag("--json", json, "One JSON object on standard output");
  return highwall::bench::RunBench(app, argc, argv, [&] {
    highwall::bench::PrintFigures(highwall::Run(data, window), json, 54);
  });
}
