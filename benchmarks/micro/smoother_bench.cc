#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <unistd.h>

#include <benchmark/benchmark.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include <highwall/core/marginalization.h>
#include <highwall/internal/processor_time.h>

#include "support/simulated_window.h"

namespace highwall::smoother_bench {
namespace {

double ResidentMegabytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0.0, resident = 0.0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

// `landmarks` in a window of `keyframes`, seven points to three lines, each observed from as many
// keyframes as fit: a window contains 2 * keyframes - 1 generations of them.
SimulatedWindowOptions Simulation(int keyframes, int landmarks) {
  const double a_keyframe = static_cast<double>(landmarks) / (2 * keyframes - 1);
  SimulatedWindowOptions options;
  options.new_points = static_cast<int>(0.7 * a_keyframe + 0.5);
  options.new_lines = static_cast<int>(a_keyframe + 0.5) - options.new_points;
  options.track_length = keyframes;
  options.loss = std::make_shared<ceres::HuberLoss>(2.5);
  return options;
}

SlidingWindowSmoother FullWindow(SimulatedWindow* simulation, int keyframes) {
  SlidingWindowSmoother smoother({.max_states = keyframes});
  for (int k = 0; k < 2 * keyframes; ++k) {
    simulation->AddKeyframe(&smoother);
    smoother.Update();
  }
  return smoother;
}

// One Update() with a new keyframe in a full window; range(0) keyframes, range(1) landmarks.
void SmootherUpdate(benchmark::State& state) {
  const int keyframes = static_cast<int>(state.range(0));
  SimulatedWindow simulation(Simulation(keyframes, static_cast<int>(state.range(1))), 1);
  SlidingWindowSmoother smoother = FullWindow(&simulation, keyframes);
  const double memory_before = ResidentMegabytes();
  std::vector<double> wall, cpu;
  double iterations = 0.0;
  for (auto _ : state) {
    simulation.AddKeyframe(&smoother);
    const double before = ProcessProcessorSeconds();
    const UpdateReport report = smoother.Update();
    cpu.push_back(1e3 * (ProcessProcessorSeconds() - before));
    if (!report.accepted) {
      state.SkipWithError(report.message.c_str());
      break;
    }
    state.SetIterationTime(report.seconds);
    wall.push_back(1e3 * report.seconds);
    iterations += report.solve.iterations;
  }
  std::sort(wall.begin(), wall.end());
  std::sort(cpu.begin(), cpu.end());
  const double count = static_cast<double>(wall.size());
  state.counters["median_ms"] = wall[wall.size() / 2];
  state.counters["median_cpu_ms"] = cpu[cpu.size() / 2];
  state.counters["p95_cpu_ms"] = cpu[cpu.size() * 95 / 100];
  state.counters["iterations"] = iterations / count;
  state.counters["factors"] = static_cast<double>(smoother.graph().NumFactors());
  state.counters["rss_before_MB"] = memory_before;
  state.counters["rss_after_MB"] = ResidentMegabytes();
}

// Marginalizes the oldest keyframe of a window with all its landmarks; nothing is restored.
void MarginalizeOldest(benchmark::State& state) {
  const int keyframes = static_cast<int>(state.range(0));
  SimulatedWindow simulation(Simulation(keyframes, static_cast<int>(state.range(1))), 1);
  SlidingWindowSmoother smoother = FullWindow(&simulation, keyframes);
  FactorGraph& graph = const_cast<FactorGraph&>(smoother.graph());
  const VariableId oldest = smoother.StatesAt(smoother.Stamps().front()).front();
  std::vector<double*> removed = {graph.MutableBlock(oldest)};
  for (const FactorId& factor : graph.FactorsOf(oldest)) {
    const std::vector<VariableId> ids = graph.VariablesOf(factor);
    double* block = graph.MutableBlock(ids.back());
    if (graph.problem().ParameterBlockSize(block) == Pose::kSize) continue;
    if (std::find(removed.begin(), removed.end(), block) == removed.end()) removed.push_back(block);
  }
  MarginalizationReport report;
  for (auto _ : state) report = Marginalize(graph.problem(), removed).report;
  state.counters["landmarks"] = static_cast<double>(removed.size() - 1);
  state.counters["factors"] = report.factors;
  state.counters["rank"] = report.rank;
}

// Compares all keyframes of a window by the information lost with them.
void CompareCandidates(benchmark::State& state) {
  const int keyframes = static_cast<int>(state.range(0));
  SimulatedWindow simulation(Simulation(keyframes, static_cast<int>(state.range(1))), 1);
  SlidingWindowSmoother smoother = FullWindow(&simulation, keyframes);
  FactorGraph& graph = const_cast<FactorGraph&>(smoother.graph());
  std::vector<std::vector<double*>> candidates;
  for (const Stamp stamp : smoother.Stamps()) {
    candidates.push_back({graph.MutableBlock(smoother.StatesAt(stamp).front())});
  }
  for (auto _ : state) benchmark::DoNotOptimize(InformationLoss(graph.problem(), candidates));
}

// Error of the newest keyframe, over 20 runs of 80 keyframes, from the 40th on. range(0): the
// policy, range(1): keyframes that observe a landmark, in a window of ten.
void LeavingPolicies(benchmark::State& state) {
  SlidingWindowOptions options{.max_states = 10};
  options.leaving =
      state.range(0) == 0 ? LeavingPolicy::kOldestFirst : LeavingPolicy::kLeastInformation;
  SimulatedWindowOptions world;
  world.new_points = 6;
  world.new_lines = 2;
  world.track_length = static_cast<int>(state.range(1));
  double position = 0.0, angle = 0.0;
  int count = 0;
  for (auto _ : state) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      SimulatedWindow simulation(world, seed);
      SlidingWindowSmoother smoother(options);
      for (int k = 0; k < 80; ++k) {
        const Variable<Pose> newest = simulation.AddKeyframe(&smoother);
        smoother.Update();
        if (k < 40) continue;
        const Pose error = SimulatedWindow::Truth(k).Inverse() * smoother.Value(newest);
        position += error.p().squaredNorm();
        angle += error.Angle() * error.Angle();
        ++count;
      }
    }
  }
  state.SetLabel(ToString(options.leaving));
  state.counters["position_mm"] = 1e3 * std::sqrt(position / count);
  state.counters["angle_mrad"] = 1e3 * std::sqrt(angle / count);
}

void Windows(benchmark::internal::Benchmark* bench) {
  for (const int keyframes : {5, 10, 20, 40}) bench->Args({keyframes, 500});
  for (const int landmarks : {100, 1000, 2000}) bench->Args({10, landmarks});
  bench->Unit(benchmark::kMillisecond);
}

BENCHMARK(SmootherUpdate)->Apply(Windows)->UseManualTime();
// Memory stays flat over 10,000 updates.
BENCHMARK(SmootherUpdate)
    ->Name("SmootherUpdateTenThousandTimes")
    ->Args({10, 500})
    ->Iterations(10000)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(MarginalizeOldest)->Apply(Windows);
BENCHMARK(LeavingPolicies)
    ->ArgsProduct({{0, 1}, {5, 10, 15, 20}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(CompareCandidates)->Args({5, 100})->Args({10, 500})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace highwall::smoother_bench
