#include "bench_loops.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include <highwall/core/so3.h>
#include <highwall/frontend/system/slam_system.h>

#include "loops/keyframe_graph.h"
#include "scenes.h"

namespace highwall::bench {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kSeconds = 8.0, kWeakFrom = 3.0, kWeakTo = 4.5;  // [s]

bool IsWeak(double time) {
  return time >= kWeakFrom && time < kWeakTo;
}

// Takes the contrast out of the colour, as where it is dark.
void Weaken(int seed, cv::Mat* colour) {
  constexpr double kContrast = 0.04, kNoise = 2.0;  // [grey levels]
  cv::Mat dark, noise(colour->size(), CV_16SC3);
  colour->convertTo(dark, CV_16SC3, kContrast, 60.0);
  cv::RNG rng(static_cast<std::uint64_t>(seed));
  rng.fill(noise, cv::RNG::NORMAL, 0.0, kNoise);
  cv::Mat(dark + noise).convertTo(*colour, CV_8UC3);
}

// Edges between successive keyframes: squared normalized errors, and errors of the translation.
struct Edges {
  std::vector<double> chi2, mm;

  void Append(const Edges& other) {
    chi2.insert(chi2.end(), other.chi2.begin(), other.chi2.end());
    mm.insert(mm.end(), other.mm.begin(), other.mm.end());
  }
};

struct EdgesOfRun {
  Edges strong, weak;
};

EdgesOfRun OfRun(const std::string& scene, int seed) {
  simulate::SimulationOptions options =
      scene == "room" ? SmallRoomOptions(seed, kSeconds) : SmallFieldTestOptions(seed, kSeconds);
  options.fps = 15.0;
  const simulate::Simulation simulation = Simulate(scene, options);
  SlamOptions slam_options = Deterministic({});
  slam_options.loops.enabled = false;
  std::optional<ImuCalibration> imu;
  std::vector<ImuSample> readings;
  if (scene != "room") {
    imu = CalibrationOf(simulation.options().imu);
    readings = simulation.ImuSamples();
  }
  SlamSystem slam({.camera = simulation.options().camera}, slam_options, SlamInputs{.imu = imu});
  std::size_t next = 0;
  for (int i = 0; i < simulation.size(); ++i) {
    auto frame = simulation.Render(i);
    if (IsWeak(i / options.fps)) Weaken(1000 * seed + i, &frame.bgr);
    for (; next < readings.size() && readings[next].stamp <= frame.stamp + 100'000'000; ++next) {
      slam.AddImu(readings[next]);
    }
    slam.Track({frame.stamp, frame.bgr, frame.depth});
  }
  const Map& map = slam.map();
  EdgesOfRun edges;
  const MeasurementModel model({.camera = simulation.options().camera}, slam_options.measurement);
  const std::vector<KeyFrameId> keyframes = map.KeyFramesOf(kFirstSubmap);
  for (std::size_t i = 1; i < keyframes.size(); ++i) {
    const KeyFrame& before = *map.keyframe(keyframes[i - 1]);
    const KeyFrame& after = *map.keyframe(keyframes[i]);
    if (before.submap != after.submap) continue;
    const Pose truth =
        simulation.T_WC(before.frame.stamp).Inverse() * simulation.T_WC(after.frame.stamp);
    const Pose E = (before.T_WC.Inverse() * after.T_WC).Inverse() * truth;
    Vector6 e;
    e << E.p(), so3::Log(E.q());
    const double chi2 = e.dot(RelativeCovariance(map, model, before.id, after.id).ldlt().solve(e));
    const bool weak = IsWeak(ToSeconds(after.frame.stamp - simulation.StampOf(0)));
    Edges& of = weak ? edges.weak : edges.strong;
    of.chi2.push_back(chi2);
    of.mm.push_back(1e3 * E.p().norm());
  }
  return edges;
}

double MeanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

nlohmann::json Report(const Edges& edges) {
  constexpr double k95Percent = 12.592;  // of chi-squared with 6 degrees of freedom
  const auto within =
      std::ranges::count_if(edges.chi2, [](double chi2) { return chi2 <= k95Percent; });
  const auto count = static_cast<double>(edges.chi2.size());
  return {{"edges", edges.chi2.size()},
          {"mean_error_mm", MeanOf(edges.mm)},
          {"mean_chi2", MeanOf(edges.chi2)},
          {"share_within_95_percent", static_cast<double>(within) / std::max(1.0, count)}};
}

}  // namespace

nlohmann::json BenchEdges(const std::string& scene, int seeds) {
  EdgesOfRun all;
  for (int seed = 1; seed <= seeds; ++seed) {
    const EdgesOfRun run = OfRun(scene, seed);
    fmt::print(stderr, "{} {:>2}: {} edges {:.2f} ({:.2f} mm), {} weak {:.2f} ({:.2f} mm)\n", scene,
               seed, run.strong.mm.size(), MeanOf(run.strong.chi2), MeanOf(run.strong.mm),
               run.weak.mm.size(), MeanOf(run.weak.chi2), MeanOf(run.weak.mm));
    all.strong.Append(run.strong);
    all.weak.Append(run.weak);
  }
  return {{"strong", Report(all.strong)}, {"weak", Report(all.weak)}};
}

}  // namespace highwall::bench
