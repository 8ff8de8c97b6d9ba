#include "system/pose_smoother.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include <ceres/loss_function.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/core/so3.h>
#include <highwall/factors/white_acceleration.h>

#include "system/chain_covariance.h"
#include "system/inertial_smoother.h"
#include "system/motion_noise.h"
#include "tracking/constant_velocity.h"

namespace highwall {
namespace {

constexpr std::size_t kWindow = 1000;  // frames smoothed at once
// Frames on either side of a window that are smoothed with it. The influence of a frame ends within
// a few neighbours; where readings of an IMU hold poses, within seconds.
constexpr std::size_t kOverlap = 150;
// Of these, the ones in which one window fades into the next.
constexpr std::size_t kFade = 50;
// Frames before the newest one that predict it, for the same reason, how many of them an image must
// measure, and how many there are at most.
constexpr std::size_t kPredictedFrom = 16, kLeastMeasured = 6, kMostPredictedFrom = 50;
// At 95 % of chi-squared with 6 and with 12 degrees of freedom: spikes of poses, cuts of motions.
constexpr double kMostOfPose = 3.5, kMostOfMotion = 4.6;

using Velocities = WhiteAcceleration::Velocities;

Velocities MeanVelocities(const MeasuredPose& i, const MeasuredPose& j, double dt) {
  Velocities u;
  u << (j.T_WB.p() - i.T_WB.p()) / dt, so3::Log(i.T_WB.q().conjugate() * j.T_WB.q()) / dt;
  return u;
}

// Poses that follow each other without a gap and the motion between them.
struct MotionGraph {
  FactorGraph graph;
  std::vector<Variable<Pose>> T_WB;
  std::vector<Variable<Velocities>> u;
};

// of_pose: loss of a pose; null: none.
MotionGraph MakeGraph(std::span<const MeasuredPose> poses, const MotionNoise& noise,
                      const std::shared_ptr<ceres::LossFunction>& of_pose) {
  MotionGraph motion;
  auto& [graph, T_WB, u] = motion;
  const auto of_motion = std::make_shared<ceres::HuberLoss>(kMostOfMotion);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    T_WB.push_back(graph.AddVariable(poses[i].T_WB));
    if (poses[i].information) {
      graph.AddFactor(
          std::make_unique<PosePrior>(poses[i].T_WB, RootInformation(poses[i], noise.pose)),
          of_pose, T_WB.back());
    } else {
      graph.Fix(T_WB.back());
    }
    const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, poses.size() - 1);
    const double dt = ToSeconds(poses[after].stamp - poses[before].stamp);
    u.push_back(graph.AddVariable(MeanVelocities(poses[before], poses[after], dt)));
    if (i == 0) continue;
    graph.AddFactor(std::make_unique<WhiteAcceleration>(
                        ToSeconds(poses[i].stamp - poses[i - 1].stamp), noise.acceleration),
                    of_motion, T_WB[i - 1], u[i - 1], T_WB[i], u[i]);
  }
  return motion;
}

bool Solve(MotionGraph* motion) {
  SolveOptions options;
  options.max_iterations = 20;
  options.linear_solver = LinearSolver::kSparseCholesky;
  return motion->graph.Solve(options).IsUsable();
}

// Returns the poses of a solved graph with their velocities.
std::vector<SmoothedPose> SmoothedPoses(MotionGraph* motion) {
  auto& [graph, T_WB, u] = *motion;
  std::vector<std::vector<double*>> states;
  for (std::size_t i = 0; i < T_WB.size(); ++i) {
    states.push_back({graph.MutableBlock(u[i])});
    if (!graph.IsFixed(T_WB[i])) states.back().push_back(graph.MutableBlock(T_WB[i]));
  }
  const std::vector<Eigen::MatrixXd> covariances = ChainCovariance(graph.problem(), states, {});
  std::vector<SmoothedPose> smoothed;
  smoothed.reserve(T_WB.size());
  for (std::size_t i = 0; i < T_WB.size(); ++i) {
    smoothed.push_back({graph.Value(T_WB[i])});
    if (covariances.empty()) continue;
    const Velocities velocities = graph.Value(u[i]);
    smoothed.back().velocity = {velocities.head<3>(), velocities.tail<3>(),
                                covariances[i].topLeftCorner<6, 6>()};
  }
  return smoothed;
}

// Smooths poses that follow each other without a gap. Empty if the graph has no solution.
std::vector<SmoothedPose> SmoothByMotion(std::span<const MeasuredPose> poses,
                                         const MotionNoise& noise) {
  MotionGraph motion = MakeGraph(poses, noise, std::make_shared<ceres::HuberLoss>(kMostOfPose));
  return Solve(&motion) ? SmoothedPoses(&motion) : std::vector<SmoothedPose>();
}

bool IsMeasured(const MeasuredPose& pose) {
  return pose.information && !pose.information->isZero(0.0);
}

// Returns the poses of which an image states something, and those that define a map.
std::vector<MeasuredPose> Informed(std::span<const MeasuredPose> poses) {
  std::vector<MeasuredPose> informed;
  std::ranges::copy_if(poses, std::back_inserter(informed), [](const MeasuredPose& pose) {
    return !pose.information || IsMeasured(pose);
  });
  return informed;
}

// Returns the end of the poses from `begin` that follow each other without a gap, all or none of
// them with readings since the one before.
std::size_t EndOfStretch(std::span<const MeasuredPose> poses, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < poses.size() &&
         ToSeconds(poses[end].stamp - poses[end - 1].stamp) <=
             ConstantVelocity::kLongestPrediction &&
         (poses[end].readings == nullptr) == (poses[begin + 1].readings == nullptr)) {
    ++end;
  }
  return end;
}

// Returns the poses with the first one of a map, which its image does not measure but defines, as
// uncertain as the next that an image measures: the keyframe made of it has the same errors as any
// other.
std::vector<MeasuredPose> WithFirstPoses(std::span<const MeasuredPose> poses) {
  std::vector<MeasuredPose> all(poses.begin(), poses.end());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].information) continue;
    const auto measured = std::ranges::find_if(poses.subspan(i), IsMeasured);
    if (measured != poses.subspan(i).end()) all[i].information = measured->information;
  }
  return all;
}

// Returns what lies between two estimates of a pose: a for weight 0, b for weight 1.
SmoothedPose Between(const SmoothedPose& a, const SmoothedPose& b, double weight) {
  const auto mean = [weight](const auto& x, const auto& y) {
    return ((1.0 - weight) * x + weight * y).eval();
  };
  SmoothedPose between{Pose(a.T_WB.q().slerp(weight, b.T_WB.q()), mean(a.T_WB.p(), b.T_WB.p()))};
  if (a.velocity && b.velocity) {
    between.velocity = {mean(a.velocity->v_WB, b.velocity->v_WB),
                        mean(a.velocity->omega_B, b.velocity->omega_B),
                        mean(a.velocity->covariance, b.velocity->covariance)};
  }
  return between;
}

// Smooths the frames [begin, end) of `poses`, with those around them. The frames before are those
// of another window, into which they fade.
void SmoothWindow(std::span<const MeasuredPose> poses, std::size_t begin, std::size_t end,
                  const std::optional<Eigen::Vector3d>& gravity_W,
                  std::vector<std::optional<SmoothedPose>>* smoothed) {
  const std::size_t first = begin - std::min(begin, kOverlap);
  const std::size_t last = std::min(end + kOverlap, poses.size());
  const std::vector<MeasuredPose> all = WithFirstPoses(poses.subspan(first, last - first));
  const std::span window(all);
  const auto noise = EstimateMotionNoise(window);
  const auto of_poses = noise ? std::optional(noise->pose) : std::nullopt;
  for (std::size_t i = 0; i < window.size();) {
    const std::size_t stretch_end = EndOfStretch(window, i);
    const auto stretch = window.subspan(i, stretch_end - i);
    i = stretch_end;
    if (stretch.size() < 3) continue;
    const bool by_readings = gravity_W && stretch[1].readings != nullptr;
    std::vector<SmoothedPose> found;
    if (by_readings) found = SmoothByReadings(stretch, of_poses, *gravity_W);
    if (found.empty() && noise) found = SmoothByMotion(stretch, *noise);
    for (std::size_t k = 0; k < found.size(); ++k) {
      const std::size_t index = first + static_cast<std::size_t>(&stretch[k] - all.data());
      if (index + kFade < begin || index >= end + kFade || !stretch[k].information) continue;
      std::optional<SmoothedPose>& pose = (*smoothed)[index];
      const double weight =
          (static_cast<double>(index + kFade) - static_cast<double>(begin) + 0.5) / (2.0 * kFade);
      pose = pose && weight < 1.0 ? Between(*pose, found[k], weight) : found[k];
    }
  }
}

// Returns the first of the poses that predict the last one.
std::size_t FirstToPredictFrom(std::span<const MeasuredPose> poses) {
  std::size_t begin = poses.size() - 1, measured = 0;
  while (begin > 0 && poses.size() - begin <= kMostPredictedFrom &&
         (poses.size() - begin <= kPredictedFrom || measured < kLeastMeasured) &&
         ToSeconds(poses[begin].stamp - poses[begin - 1].stamp) <=
             ConstantVelocity::kLongestPrediction) {
    --begin;
    measured += IsMeasured(poses[begin]) ? 1 : 0;
  }
  return begin;
}

}  // namespace

std::vector<std::optional<SmoothedPose>> SmoothPoses(
    std::span<const MeasuredPose> poses, const std::optional<Eigen::Vector3d>& gravity_W) {
  std::vector<std::optional<SmoothedPose>> smoothed(poses.size());
  for (std::size_t begin = 0; begin < poses.size(); begin += kWindow) {
    SmoothWindow(poses, begin, std::min(begin + kWindow, poses.size()), gravity_W, &smoothed);
  }
  return smoothed;
}

std::optional<Pose> PredictLastPose(std::span<const MeasuredPose> poses) {
  const std::size_t begin = FirstToPredictFrom(poses);
  const auto noise = EstimateMotionNoise(Informed(poses));
  if (!noise || poses.size() - begin < 3) return std::nullopt;
  // Without a loss of the poses: only poses after it show whether the newest one is a spike or the
  // beginning of another motion.
  MotionGraph motion = MakeGraph(poses.subspan(begin), *noise, nullptr);
  return Solve(&motion) ? motion.graph.Value(motion.T_WB.back()) : poses.back().T_WB;
}

}  // namespace highwall
