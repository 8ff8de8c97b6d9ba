#include <vector>

#include <benchmark/benchmark.h>

#include <highwall/factors/imu_preintegration.h>

namespace highwall::imu_preintegration_bench {
namespace {

// Nanoseconds per sample: an interval of `range` samples at 200 Hz, with the 15 x 15 covariance and
// the bias Jacobian.
void Preintegrate(benchmark::State& state) {
  std::vector<ImuSample> samples;
  for (int i = 0; i <= state.range(0); ++i) {
    const double t = 0.005 * i;
    samples.push_back({i * 5'000'000, {0.3 * t, -0.5, 0.8}, {0.4, 0.3 * t, 9.81}});
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(ImuPreintegration(samples, ImuBias::Constant(0.01)));
  }
  state.counters["per_sample"] =
      benchmark::Counter(static_cast<double>(state.iterations() * state.range(0)),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(Preintegrate)->Arg(7)->Arg(40)->Arg(100);

}  // namespace
}  // namespace highwall::imu_preintegration_bench
