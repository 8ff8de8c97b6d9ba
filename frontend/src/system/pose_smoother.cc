#include "system/pose_smoother.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>

#include <ceres/loss_function.h>
#include <Eigen/Eigenvalues>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/core/so3.h>
#include <highwall/factors/white_acceleration.h>

#include "system/motion_noise.h"
#include "tracking/constant_velocity.h"

namespace highwall {
namespace {

constexpr std::size_t kWindow = 1000;  // frames smoothed at once
// Frames on either side of a window that are smoothed with it and not kept. The influence of a
// frame ends within a few neighbours.
constexpr std::size_t kOverlap = 50;

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Velocities = WhiteAcceleration::Velocities;

// Returns W with W^T W the information of the pose in the tangent space of PoseManifold, reduced
// by the scales of the noise. It may be singular.
Matrix6 Root(const MeasuredPose& pose, const MotionNoise& noise) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(pose.information->cast<double>());
  const Matrix6 root_C =
      eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
  Matrix6 root = root_C;
  root.leftCols<3>() = root_C.leftCols<3>() * pose.T_WC.R().transpose() / noise.position_scale;
  root.rightCols<3>() = root_C.rightCols<3>() / noise.rotation_scale;
  return root;
}

Velocities MeanVelocities(const MeasuredPose& i, const MeasuredPose& j, double dt) {
  Velocities u;
  u << (j.T_WC.p() - i.T_WC.p()) / dt, so3::Log(i.T_WC.q().conjugate() * j.T_WC.q()) / dt;
  return u;
}

// Smooths poses that follow each other without a gap.
std::vector<Pose> Smoothed(std::span<const MeasuredPose> poses, const MotionNoise& noise) {
  FactorGraph graph;
  // At 95 % of chi-squared with 6 and with 12 degrees of freedom: spikes of poses, cuts of motions.
  const auto of_pose = std::make_shared<ceres::HuberLoss>(3.5);
  const auto of_motion = std::make_shared<ceres::HuberLoss>(4.6);
  std::vector<Variable<Pose>> T_WC;
  std::vector<Variable<Velocities>> u;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    T_WC.push_back(graph.AddVariable(poses[i].T_WC));
    if (poses[i].information) {
      graph.AddFactor(std::make_unique<PosePrior>(poses[i].T_WC, Root(poses[i], noise)), of_pose,
                      T_WC.back());
    } else {
      graph.Fix(T_WC.back());
    }
    const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, poses.size() - 1);
    const double dt = ToSeconds(poses[after].stamp - poses[before].stamp);
    u.push_back(graph.AddVariable(MeanVelocities(poses[before], poses[after], dt)));
    if (i == 0) continue;
    graph.AddFactor(std::make_unique<WhiteAcceleration>(
                        ToSeconds(poses[i].stamp - poses[i - 1].stamp), noise.acceleration),
                    of_motion, T_WC[i - 1], u[i - 1], T_WC[i], u[i]);
  }
  SolveOptions options;
  options.max_iterations = 20;
  options.linear_solver = LinearSolver::kSparseCholesky;
  std::vector<Pose> smoothed;
  smoothed.reserve(poses.size());
  const bool usable = graph.Solve(options).IsUsable();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    smoothed.push_back(usable ? graph.Value(T_WC[i]) : poses[i].T_WC);
  }
  return smoothed;
}

// Returns the end of the poses from `begin` that follow each other without a gap.
std::size_t EndOfStretch(std::span<const MeasuredPose> poses, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < poses.size() && ToSeconds(poses[end].stamp - poses[end - 1].stamp) <=
                                   ConstantVelocity::kLongestPrediction) {
    ++end;
  }
  return end;
}

// Smooths the frames [begin, end) of `poses`, with those around them.
void SmoothWindow(std::span<const MeasuredPose> poses, std::size_t begin, std::size_t end,
                  std::vector<Pose>* smoothed) {
  const std::size_t first = begin - std::min(begin, kOverlap);
  const std::size_t last = std::min(end + kOverlap, poses.size());
  const auto window = poses.subspan(first, last - first);
  const auto noise = EstimateMotionNoise(window);
  if (!noise) return;
  for (std::size_t i = 0; i < window.size();) {
    const std::size_t stretch_end = EndOfStretch(window, i);
    const auto stretch = window.subspan(i, stretch_end - i);
    if (stretch.size() >= 3) {
      const std::vector<Pose> found = Smoothed(stretch, *noise);
      for (std::size_t k = 0; k < found.size(); ++k) {
        const std::size_t index = first + i + k;
        if (index >= begin && index < end) (*smoothed)[index] = found[k];
      }
    }
    i = stretch_end;
  }
}

}  // namespace

std::vector<Pose> SmoothPoses(std::span<const MeasuredPose> poses) {
  std::vector<Pose> smoothed;
  smoothed.reserve(poses.size());
  for (const MeasuredPose& pose : poses) smoothed.push_back(pose.T_WC);
  for (std::size_t begin = 0; begin < poses.size(); begin += kWindow) {
    SmoothWindow(poses, begin, std::min(begin + kWindow, poses.size()), &smoothed);
  }
  return smoothed;
}

}  // namespace highwall
