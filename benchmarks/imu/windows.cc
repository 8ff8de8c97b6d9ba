#include "windows.h"

#include <memory>

#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>
#include <highwall/factors/imu_factor.h>

namespace highwall::bench {

Windows Cut(const Recording& recording, double length, const ImuNoise& noise) {
  constexpr double kTolerance = 1e-3;  // [s] of the stamps
  const std::vector<TrueState>& truth = recording.truth;
  Windows windows;
  for (std::size_t i = 0; i < truth.size();) {
    std::size_t j = i + 1;
    while (j < truth.size() && ToSeconds(truth[j].stamp - truth[i].stamp) < length - kTolerance) {
      ++j;
    }
    if (j == truth.size()) break;
    const auto interval = recording.imu.Between(truth[i].stamp, truth[j].stamp);
    if (interval && !interval->HasGap()) {
      windows.all.push_back({ImuPreintegration(interval->samples, truth[i].bias, {.noise = noise}),
                             truth[i], truth[j]});
    } else {
      ++windows.skipped;
    }
    i = j;
  }
  return windows;
}

Eigen::Matrix<double, 9, 1> PredictionError(const Window& w, const Eigen::Vector3d& gravity_W) {
  const ImuState predicted = w.imu.Predict(w.from.state, w.from.bias, gravity_W);
  const Eigen::Quaterniond q_BW = w.from.state.T_WB.q().conjugate();
  Eigen::Matrix<double, 9, 1> e;
  e << so3::Log(predicted.T_WB.q().conjugate() * w.to.state.T_WB.q()),
      q_BW * (w.to.state.v_WB - predicted.v_WB), q_BW * (w.to.state.T_WB.p() - predicted.T_WB.p());
  return e;
}

Surroundings EstimateSurroundings(const std::vector<Window>& windows, bool with_bias) {
  FactorGraph graph;
  const auto known = [&graph](const auto& value) {
    const auto variable = graph.AddVariable(value);
    graph.Fix(variable);
    return variable;
  };
  const auto direction = graph.AddVariable(UnitDirection());
  const auto bias = graph.AddVariable(ImuBias(ImuBias::Zero()));
  if (!with_bias) graph.Fix(bias);
  for (const Window& w : windows) {
    // The bias at the end is free: only its random walk would constrain it.
    const auto begins = with_bias ? bias : known(w.from.bias);
    graph.AddFactor(std::make_unique<ImuGravityFactor>(w.imu), known(w.from.state.T_WB),
                    known(w.from.state.v_WB), begins, known(w.to.state.T_WB),
                    known(w.to.state.v_WB), graph.AddVariable(w.from.bias), direction);
  }
  graph.Solve();
  return {.gravity_W = kStandardGravity * graph.Value(direction).vector(),
          .bias = with_bias ? graph.Value(bias) : ImuBias(ImuBias::Zero())};
}

}  // namespace highwall::bench
