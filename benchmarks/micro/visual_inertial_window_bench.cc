#include <algorithm>
#include <vector>

#include <benchmark/benchmark.h>

#include "frontend/mapped_drive.h"

namespace highwall {
namespace {

// A state more in a window of ten: range(0) points and range(1) lines of an image at most. What is
// in the window is counted.
void WindowAdd(benchmark::State& state) {
  InertialOptions options;
  options.tight.max_points = static_cast<int>(state.range(0));
  options.tight.max_lines = static_cast<int>(state.range(1));
  testing::MappedDrive drive({}, options, {}, 1.0, 0.0, /*density=*/5);
  drive.Go(20);  // until it is full, and landmarks begin at any of its states
  std::vector<double> milliseconds;
  double factors = 0.0, variables = 0.0;
  for (auto _ : state) {
    drive.Go(1);
    state.SetIterationTime(drive.seconds());
    milliseconds.push_back(1e3 * drive.seconds());
    factors += static_cast<double>(drive.window().smoother().graph().NumFactors());
    variables += static_cast<double>(drive.window().smoother().graph().NumVariables());
  }
  std::sort(milliseconds.begin(), milliseconds.end());
  const double count = static_cast<double>(milliseconds.size());
  state.counters["median_ms"] = milliseconds[milliseconds.size() / 2];
  state.counters["p95_ms"] = milliseconds[milliseconds.size() * 95 / 100];
  state.counters["factors"] = factors / count;
  state.counters["landmarks"] = variables / count - 42.0;  // ten states of four, gravity, t_d
}

BENCHMARK(WindowAdd)->Args({500, 60})->Args({250, 30})->UseManualTime()->Unit(
    benchmark::kMillisecond);

}  // namespace
}  // namespace highwall
