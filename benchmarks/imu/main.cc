// Evaluates IMU preintegration against the ground truth of a recording: predicts the state at the
// end of a window from the true state at its start. Prints median errors, and normalized squared
// errors (relative to the median of chi-square: 1 if the covariance is correct), with the
// covariance of the IMU alone, and including the errors of the ground truth, which are estimated
// from windows of other lengths (truth_noise.h).
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/App.hpp>
#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/internal/median.h>

#include "bench_main.h"
#include "truth_noise.h"
#include "windows.h"

namespace highwall::bench {
namespace {

constexpr double kDegrees = 180.0 / M_PI;
constexpr const char* kParts[] = {"rotation", "velocity", "position"};

nlohmann::json MedianErrors(const std::vector<Window>& windows, const Eigen::Vector3d& gravity_W) {
  std::vector<double> errors[3];
  for (const Window& w : windows) {
    const auto e = PredictionError(w, gravity_W);
    for (int i = 0; i < 3; ++i) errors[i].push_back(e.segment<3>(3 * i).norm());
  }
  return {{"rotation_deg", kDegrees * UpperMedian(errors[0])},
          {"velocity_m_s", UpperMedian(errors[1])},
          {"position_m", UpperMedian(errors[2])}};
}

// truth: nullptr: the IMU alone.
nlohmann::json Normalised(const std::vector<Window>& windows, const Eigen::Vector3d& gravity_W,
                          const TruthNoise* truth) {
  std::vector<double> normalised[3];
  for (const Window& w : windows) {
    const auto e = PredictionError(w, gravity_W);
    Eigen::Matrix<double, 9, 9> P = w.imu.covariance().topLeftCorner<9, 9>();
    if (truth != nullptr) P += truth->Covariance(w);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d part = e.segment<3>(3 * i);
      normalised[i].push_back(part.dot(P.block<3, 3>(3 * i, 3 * i).llt().solve(part)));
    }
  }
  nlohmann::json json;
  for (int i = 0; i < 3; ++i) json[kParts[i]] = UpperMedian(normalised[i]) / kMedianOfChi2;
  return json;
}

// Estimates the constant bias that fits best if the ground truth has none.
void FindBiases(Recording* recording, double length, const ImuNoise& noise) {
  constexpr int kPasses = 3;  // the integration is linearized at the previous bias
  for (int pass = 0; pass < kPasses && !recording->has_biases; ++pass) {
    const auto windows = Cut(*recording, length, noise);
    if (windows.all.empty()) return;
    const ImuBias bias = EstimateSurroundings(windows.all, true).bias;
    for (TrueState& truth : recording->truth) truth.bias = bias;
  }
}

nlohmann::json Run(const std::filesystem::path& folder, double length, const ImuNoise& noise) {
  Recording recording = ReadRecording(folder);
  FindBiases(&recording, length, noise);
  const Windows windows = Cut(recording, length, noise);
  if (windows.all.empty()) throw IoError(folder, "no window has both readings and states");
  std::vector<double> motion;
  for (const Window& w : windows.all) {
    motion.push_back((w.to.state.T_WB.p() - w.from.state.T_WB.p()).norm());
  }
  const Eigen::Vector3d down(0.0, 0.0, -kStandardGravity);
  const Eigen::Vector3d gravity_W = EstimateSurroundings(windows.all, false).gravity_W;
  const TruthNoise truth = EstimateTruthNoise(recording, noise, gravity_W, length);
  nlohmann::json rotation;
  for (const auto& [seconds, angle] : truth.rotation) {
    rotation[fmt::format("{:07.4f}_s", seconds)] = kDegrees * angle;
  }
  return {{"windows", windows.all.size()},
          {"skipped", windows.skipped},
          {"window_s", length},
          {"median_motion_m", UpperMedian(motion)},
          {"median_errors", MedianErrors(windows.all, down)},
          {"gravity_tilt_deg",
           std::atan2(down.cross(gravity_W).norm(), down.dot(gravity_W)) * kDegrees},
          {"median_errors_gravity_estimated", MedianErrors(windows.all, gravity_W)},
          {"normalised_by_imu", Normalised(windows.all, gravity_W, nullptr)},
          {"normalised_by_both", Normalised(windows.all, gravity_W, &truth)},
          {"truth_noise",
           {{"orientation_deg", kDegrees * truth.orientation},
            {"velocity_m_s", truth.velocity},
            {"position_m", truth.position},
            {"rotation_deg_over", rotation}}}};
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  CLI::App app(
      "IMU preintegration against the ground truth of a recording.\nExample: "
      "highwall_bench_imu --data ../shared/data/euroc_v101 --json",
      "highwall_bench_imu");
  std::string data;
  double window = 0.5;
  std::vector<double> noise;
  bool json = false;
  app.add_option("--data", data,
                 "Folder with imu.csv and groundtruth.csv (EuRoC) or groundtruth.txt (TUM)")
      ->required();
  app.add_option("--window", window, "Length of a prediction [s]")->check(CLI::PositiveNumber);
  app.add_option("--noise", noise,
                 "Densities of gyroscope, accelerometer and their walks; default: EuRoC's")
      ->delimiter(',')
      ->expected(4)
      ->check(CLI::PositiveNumber);
  app.add_flag("--json", json, "One JSON object on standard output");
  return highwall::bench::RunBench(app, argc, argv, [&] {
    highwall::ImuNoise densities;
    if (!noise.empty()) densities = {noise[0], noise[1], noise[2], noise[3]};
    highwall::bench::PrintFigures(highwall::bench::Run(data, window, densities), json, 54);
  });
}
