#include "system/inertial_smoother.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <set>

#include <ceres/loss_function.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/factors/imu_factor.h>

#include "system/chain_covariance.h"

namespace highwall {
namespace {

struct BodyState {
  Variable<Pose> T_WB;
  Variable<Eigen::Vector3d> v_WB;
  Variable<ImuBias> bias;
};

Eigen::Vector3d MeanVelocity(std::span<const MeasuredPose> poses, std::size_t i) {
  const MeasuredPose& before = poses[i > 0 ? i - 1 : 0];
  const MeasuredPose& after = poses[std::min(i + 1, poses.size() - 1)];
  return (after.T_WB.p() - before.T_WB.p()) / ToSeconds(after.stamp - before.stamp);
}

// Returns how many of the poses state as much as one: images that follow the same keyframe see the
// same landmarks and share most of their errors. Not more than those of a second, as long as
// readings hold a pose against images; an error that lasts longer contradicts no readings.
double SharedBy(std::span<const MeasuredPose> poses) {
  constexpr double kHeld = 1.0;  // [s]
  std::set<KeyFrameId> keyframes;
  for (const MeasuredPose& pose : poses) keyframes.insert(pose.reference);
  const auto number = static_cast<double>(poses.size());
  const double a_second = number * kHeld / ToSeconds(poses.back().stamp - poses.front().stamp);
  return std::max(1.0, std::min(number / static_cast<double>(keyframes.size()), a_second));
}

// A reading of the gyroscope at the time of a pose.
struct AngularRate {
  Eigen::Vector3d measured = Eigen::Vector3d::Zero();  // [rad/s]
  double variance = 0.0;                               // of each axis, without the bias
};

// Empty if readings beside the pose were contradicted: they may be those of an impact.
std::optional<AngularRate> RateAt(std::span<const MeasuredPose> poses, std::size_t i) {
  const bool is_last = i + 1 == poses.size();
  if ((i > 0 && poses[i].readings->contradicted) ||
      (!is_last && poses[i + 1].readings->contradicted)) {
    return std::nullopt;
  }
  const ReadingsBetween& readings = *poses[is_last ? i : i + 1].readings;
  const std::vector<ImuSample>& samples = readings.samples;
  const std::size_t k = is_last ? samples.size() - 1 : 0;
  // The longest, since the first and the last reading of an interval are interpolated.
  double period = 0.0;
  for (std::size_t s = 1; s < samples.size(); ++s) {
    period = std::max(period, ToSeconds(samples[s].stamp - samples[s - 1].stamp));
  }
  return AngularRate{samples[k].gyroscope,
                     readings.noise.gyroscope * readings.noise.gyroscope / period};
}

// Adds the velocities of the states of a solved graph.
void AddVelocities(std::span<const MeasuredPose> poses, const std::vector<BodyState>& states,
                   const VariableId& gravity, FactorGraph* graph,
                   std::vector<SmoothedPose>* smoothed) {
  std::vector<std::vector<double*>> blocks;
  for (const BodyState& state : states) {
    blocks.push_back({graph->MutableBlock(state.v_WB), graph->MutableBlock(state.bias)});
    if (!graph->IsFixed(state.T_WB)) blocks.back().push_back(graph->MutableBlock(state.T_WB));
  }
  const std::vector<Eigen::MatrixXd> covariances =
      ChainCovariance(graph->problem(), blocks, std::vector{graph->MutableBlock(gravity)});
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    const std::optional<AngularRate> rate = RateAt(poses, i);
    if (!rate) continue;
    BodyVelocity& velocity = (*smoothed)[i].velocity.emplace();
    velocity.v_WB = graph->Value(states[i].v_WB);
    velocity.omega_B = rate->measured - graph->Value(states[i].bias).head<3>();
    velocity.covariance = covariances[i].topLeftCorner<6, 6>();
    velocity.covariance.topRightCorner<3, 3>() *= -1.0;  // an error of the bias has its sign
    velocity.covariance.bottomLeftCorner<3, 3>() *= -1.0;
    velocity.covariance.bottomRightCorner<3, 3>().diagonal().array() += rate->variance;
  }
}

}  // namespace

std::vector<SmoothedPose> SmoothByReadings(std::span<const MeasuredPose> poses,
                                           const std::optional<PoseNoise>& usual,
                                           const Eigen::Vector3d& gravity_W) {
  std::vector<ImuPreintegration> steps;
  for (const MeasuredPose& pose : poses.subspan(1)) {
    const ReadingsBetween& readings = *pose.readings;
    steps.emplace_back(readings.samples, readings.bias,
                       ImuPreintegrationOptions{.noise = readings.noise});
  }
  auto noise = EstimatePoseNoise(poses, steps, gravity_W);
  if (!noise) noise = usual;
  if (!noise) return {};
  const double shared = 1.0 / std::sqrt(SharedBy(poses));
  FactorGraph graph;
  // At 95 % of chi-squared with 6 and with 15 degrees of freedom.
  const auto of_pose = std::make_shared<ceres::HuberLoss>(3.5);
  const std::shared_ptr<ceres::LossFunction> of_readings = std::make_shared<ceres::HuberLoss>(5.0);
  // Poses that are refined may agree with the readings that contradicted them when they were
  // tracked; those of an impact on the sensor must state nothing.
  const std::shared_ptr<ceres::LossFunction> of_contradicted =
      std::make_shared<ceres::CauchyLoss>(5.0);
  const auto gravity = graph.AddVariable(UnitDirection(gravity_W));
  std::vector<BodyState> states;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const ReadingsBetween& readings = *poses[std::max<std::size_t>(i, 1)].readings;
    states.push_back({graph.AddVariable(poses[i].T_WB), graph.AddVariable(MeanVelocity(poses, i)),
                      graph.AddVariable(readings.bias)});
    const BodyState& state = states.back();
    if (poses[i].information) {
      graph.AddFactor(
          std::make_unique<PosePrior>(poses[i].T_WB, shared * RootInformation(poses[i], *noise)),
          of_pose, state.T_WB);
    } else {
      graph.Fix(state.T_WB);
    }
    if (i == 0) {
      graph.AddFactor(std::make_unique<VectorPrior<6>>(
                          readings.bias, readings.bias_sigma.cwiseInverse().asDiagonal()),
                      state.bias);
      continue;
    }
    const BodyState& before = states[i - 1];
    graph.AddFactor(
        std::make_unique<ImuGravityFactor>(steps[i - 1], kStandardGravity, readings.weight),
        readings.contradicted ? of_contradicted : of_readings, before.T_WB, before.v_WB,
        before.bias, state.T_WB, state.v_WB, state.bias, gravity);
  }
  SolveOptions options;
  options.max_iterations = 20;
  options.linear_solver = LinearSolver::kSparseCholesky;
  if (!graph.Solve(options).IsUsable()) return {};
  std::vector<SmoothedPose> smoothed;
  smoothed.reserve(poses.size());
  for (const BodyState& state : states) smoothed.push_back({graph.Value(state.T_WB)});
  AddVelocities(poses, states, gravity, &graph, &smoothed);
  return smoothed;
}

}  // namespace highwall
