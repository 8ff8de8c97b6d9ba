#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <ceres/cost_function.h>

namespace highwall {

// Times Evaluate of a cost function at one state.
inline void TimeEvaluate(benchmark::State& state, const ceres::CostFunction& cost,
                         const std::vector<std::vector<double>>& blocks, bool with_jacobians) {
  std::vector<double> residuals(static_cast<std::size_t>(cost.num_residuals()));
  std::vector<const double*> parameters;
  std::vector<std::vector<double>> storage;
  for (const auto& block : blocks) {
    parameters.push_back(block.data());
    storage.emplace_back(residuals.size() * block.size());
  }
  std::vector<double*> jacobians;
  for (auto& J : storage) jacobians.push_back(J.data());
  for (auto _ : state) {
    benchmark::DoNotOptimize(cost.Evaluate(parameters.data(), residuals.data(),
                                           with_jacobians ? jacobians.data() : nullptr));
    benchmark::ClobberMemory();
  }
}

// Registers <name>/{factor,autodiff}/{residual,jacobian}: the factor and its autodiff twin.
inline void RegisterEvaluate(const std::string& name, std::shared_ptr<ceres::CostFunction> factor,
                             std::shared_ptr<ceres::CostFunction> twin,
                             const std::vector<std::vector<double>>& blocks) {
  const std::pair<const char*, std::shared_ptr<ceres::CostFunction>> costs[] = {
      {"factor", std::move(factor)}, {"autodiff", std::move(twin)}};
  for (const bool with_jacobians : {false, true}) {
    for (const auto& [kind, cost] : costs) {
      const std::string full = name + "/" + kind + (with_jacobians ? "/jacobian" : "/residual");
      benchmark::RegisterBenchmark(full.c_str(), [=, c = cost](benchmark::State& state) {
        TimeEvaluate(state, *c, blocks, with_jacobians);
      });
    }
  }
}

}  // namespace highwall
