#include "system/inertial_smoother.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>

#include <ceres/loss_function.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/frontend/inertial/options.h>

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

}  // namespace

std::vector<Pose> SmoothByReadings(std::span<const MeasuredPose> poses, const MotionNoise& noise,
                                   const Eigen::Vector3d& gravity_W) {
  // The readings hold poses over seconds, in which neighbouring images, which see the same
  // landmarks, share most of their errors: as in the smoother of InertialOdometry.
  const double shared = 1.0 / std::sqrt(VisualNoise().scale);
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
          std::make_unique<PosePrior>(poses[i].T_WB, shared * RootInformation(poses[i], noise)),
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
    const ImuPreintegration imu(readings.samples, readings.bias, {.noise = readings.noise});
    graph.AddFactor(std::make_unique<ImuGravityFactor>(imu, kStandardGravity, readings.weight),
                    readings.contradicted ? of_contradicted : of_readings, before.T_WB, before.v_WB,
                    before.bias, state.T_WB, state.v_WB, state.bias, gravity);
  }
  SolveOptions options;
  options.max_iterations = 20;
  options.linear_solver = LinearSolver::kSparseCholesky;
  if (!graph.Solve(options).IsUsable()) return {};
  std::vector<Pose> smoothed;
  smoothed.reserve(poses.size());
  for (const BodyState& state : states) smoothed.push_back(graph.Value(state.T_WB));
  return smoothed;
}

}  // namespace highwall
