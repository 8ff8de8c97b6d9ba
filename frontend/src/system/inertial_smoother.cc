#include "system/inertial_smoother.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include <ceres/loss_function.h>

#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/core/so3.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/internal/median.h>

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

// The angular rates at poses that readings follow.
class AngularRates {
 public:
  explicit AngularRates(std::span<const MeasuredPose> poses) : poses_(poses) {
    std::vector<double> periods;
    for (const MeasuredPose& pose : poses.subspan(1)) {
      const std::vector<ImuSample>& samples = pose.readings->samples;
      for (std::size_t s = 1; s < samples.size(); ++s) periods.push_back(Step(samples, s));
    }
    period_ = UpperMedian(std::move(periods));
  }

  // Empty beside readings that were contradicted, which may be those of an impact, and beside
  // missing ones.
  std::optional<AngularRate> At(std::size_t i) const {
    const bool is_last = i + 1 == poses_.size();
    if ((i > 0 && !IsGood(i, poses_[i].readings->samples.size() - 1)) ||
        (!is_last && !IsGood(i + 1, 1))) {
      return std::nullopt;
    }
    const ReadingsBetween& readings = *poses_[is_last ? i : i + 1].readings;
    const ImuSample& sample = is_last ? readings.samples.back() : readings.samples.front();
    return AngularRate{sample.gyroscope,
                       readings.noise.gyroscope * readings.noise.gyroscope / period_};
  }

 private:
  static double Step(const std::vector<ImuSample>& samples, std::size_t to) {
    return ToSeconds(samples[to].stamp - samples[to - 1].stamp);
  }
  bool IsGood(std::size_t pose, std::size_t step) const {
    constexpr double kMostPeriods = 3.0;
    const ReadingsBetween& readings = *poses_[pose].readings;
    return !readings.contradicted && Step(readings.samples, step) <= kMostPeriods * period_;
  }

  const std::span<const MeasuredPose> poses_;
  double period_ = 0.0;  // [s] median, since readings at poses are interpolated
};

// Poses that follow each other, with the readings between them.
class InertialGraph {
 public:
  // steps: the readings since the pose before, of each pose but the first. shared: number of images
  // that state as much as one.
  InertialGraph(std::span<const MeasuredPose> poses, std::span<const ImuPreintegration> steps,
                const PoseNoise& noise, double shared, const Eigen::Vector3d& gravity_W)
      : poses_(poses), noise_(noise) {
    gravity_ = graph_.AddVariable(UnitDirection(gravity_W));
    for (std::size_t i = 0; i < poses.size(); ++i) AddState(i, 1.0 / std::sqrt(shared));
    const ReadingsBetween& first = *poses[1].readings;
    graph_.AddFactor(
        std::make_unique<VectorPrior<6>>(first.bias, first.bias_sigma.cwiseInverse().asDiagonal()),
        states_.front().bias);
    for (std::size_t i = 1; i < poses.size(); ++i) AddReadings(i, steps[i - 1]);
  }

  bool Solve() {
    SolveOptions options;
    options.max_iterations = 20;
    options.linear_solver = LinearSolver::kSparseCholesky;
    return graph_.Solve(options).IsUsable();
  }

  // Returns the median of the squared errors of the images by their own noise, over that of
  // chi-squared: 1 if they share none.
  double ImageError() const {
    constexpr double kMedianOfChi2 = 5.348;  // with 6 degrees of freedom
    std::vector<double> squares;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const MeasuredPose& pose = poses_[i];
      if (!pose.information || pose.information->isZero(0.0F)) continue;
      const Pose smoothed = graph_.Value(states_[i].T_WB);
      Eigen::Matrix<double, 6, 1> error;
      error << smoothed.p() - pose.T_WB.p(), so3::Log(pose.T_WB.q().conjugate() * smoothed.q());
      squares.push_back((RootInformation(pose, noise_) * error).squaredNorm());
    }
    return squares.empty() ? 0.0 : UpperMedian(std::move(squares)) / kMedianOfChi2;
  }

  // Returns the poses of the solved graph with their velocities.
  std::vector<SmoothedPose> Smoothed() {
    std::vector<SmoothedPose> smoothed;
    smoothed.reserve(states_.size());
    for (const BodyState& state : states_) smoothed.push_back({graph_.Value(state.T_WB)});
    const std::vector<Eigen::MatrixXd> covariances = Covariances();
    const AngularRates rates(poses_);
    for (std::size_t i = 0; i < covariances.size(); ++i) {
      const std::optional<AngularRate> rate = rates.At(i);
      if (!rate) continue;
      BodyVelocity& velocity = smoothed[i].velocity.emplace();
      velocity.v_WB = graph_.Value(states_[i].v_WB);
      velocity.omega_B = rate->measured - graph_.Value(states_[i].bias).head<3>();
      velocity.covariance = covariances[i].topLeftCorner<6, 6>();
      velocity.covariance.topRightCorner<3, 3>() *= -1.0;  // an error of the bias has its sign
      velocity.covariance.bottomLeftCorner<3, 3>() *= -1.0;
      velocity.covariance.bottomRightCorner<3, 3>().diagonal().array() += rate->variance;
    }
    return smoothed;
  }

 private:
  void AddState(std::size_t i, double weight) {
    const ReadingsBetween& readings = *poses_[std::max<std::size_t>(i, 1)].readings;
    const MeasuredPose& pose = poses_[i];
    states_.push_back({graph_.AddVariable(pose.T_WB), graph_.AddVariable(MeanVelocity(poses_, i)),
                       graph_.AddVariable(readings.bias)});
    if (!pose.information) {
      graph_.Fix(states_.back().T_WB);
      return;
    }
    graph_.AddFactor(std::make_unique<PosePrior>(pose.T_WB, weight * RootInformation(pose, noise_)),
                     of_pose_, states_.back().T_WB);
  }

  void AddReadings(std::size_t i, const ImuPreintegration& step) {
    const ReadingsBetween& readings = *poses_[i].readings;
    const BodyState &before = states_[i - 1], &state = states_[i];
    graph_.AddFactor(std::make_unique<ImuGravityFactor>(step, kStandardGravity, readings.weight),
                     readings.contradicted ? of_contradicted_ : of_readings_, before.T_WB,
                     before.v_WB, before.bias, state.T_WB, state.v_WB, state.bias, gravity_);
  }

  // Of each state: velocity, bias, and pose where it is not fixed.
  std::vector<Eigen::MatrixXd> Covariances() {
    std::vector<std::vector<double*>> blocks;
    for (const BodyState& state : states_) {
      blocks.push_back({graph_.MutableBlock(state.v_WB), graph_.MutableBlock(state.bias)});
      if (!graph_.IsFixed(state.T_WB)) blocks.back().push_back(graph_.MutableBlock(state.T_WB));
    }
    return ChainCovariance(graph_.problem(), blocks, std::vector{graph_.MutableBlock(gravity_)});
  }

  const std::span<const MeasuredPose> poses_;
  const PoseNoise noise_;
  FactorGraph graph_;
  Variable<UnitDirection> gravity_;
  std::vector<BodyState> states_;
  // At 95 % of chi-squared with 6 and with 15 degrees of freedom.
  const std::shared_ptr<ceres::LossFunction> of_pose_ = std::make_shared<ceres::HuberLoss>(3.5);
  const std::shared_ptr<ceres::LossFunction> of_readings_ = std::make_shared<ceres::HuberLoss>(5.0);
  // Poses that are refined may agree with the readings that contradicted them when they were
  // tracked; those of an impact on the sensor must state nothing.
  const std::shared_ptr<ceres::LossFunction> of_contradicted_ =
      std::make_shared<ceres::CauchyLoss>(5.0);
};

}  // namespace

std::vector<SmoothedPose> SmoothByReadings(std::span<const MeasuredPose> poses,
                                           const std::optional<PoseNoise>& usual,
                                           const Eigen::Vector3d& gravity_W) {
  // Images share errors of up to twice their own; beyond that it is the readings that err.
  constexpr double kMostImageError = 4.0;
  std::vector<ImuPreintegration> steps;
  for (const MeasuredPose& pose : poses.subspan(1)) {
    const ReadingsBetween& readings = *pose.readings;
    steps.emplace_back(readings.samples, readings.bias,
                       ImuPreintegrationOptions{.noise = readings.noise});
  }
  auto noise = EstimatePoseNoise(poses, steps, gravity_W);
  if (!noise) noise = usual;
  if (!noise) return {};
  for (double shared = SharedBy(poses);; shared = std::max(1.0, shared / 2.0)) {
    InertialGraph graph(poses, steps, *noise, shared, gravity_W);
    if (!graph.Solve()) return {};
    if (graph.ImageError() <= kMostImageError) return graph.Smoothed();
    if (shared == 1.0) return {};
  }
}

}  // namespace highwall
