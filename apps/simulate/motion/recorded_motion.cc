#include "simulate/motion/recorded_motion.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/prior.h>
#include <highwall/core/so3.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

namespace highwall::simulate {
namespace {

constexpr double kShortest = 3.0;          // [s]
constexpr double kHole = 3.0;              // median steps without captured poses: interpolated
constexpr double kLeastCaptured = 0.5;     // of all states; otherwise it is dead reckoning
constexpr double kWorstOrientation = 0.1;  // [rad] median: worse than any motion capture
constexpr double kEnds = 0.5;              // [s] where the spline closes and is not the motion

struct Node {
  Stamp stamp = 0;
  Pose captured;          // T_WB
  bool is_guess = false;  // within a gap
};

// Creates a node at every interval of the common time span.
std::vector<Node> LayOutNodes(const Trajectory& captured, std::span<const ImuSample> readings,
                              double interval) {
  const Stamp begin = std::max(captured.front().stamp, readings.front().stamp);
  const Stamp end = std::min(captured.back().stamp, readings.back().stamp);
  HIGHWALL_REQUIRE(ToSeconds(end - begin) >= kShortest,
                   "motion and readings share less than " + FixedText(kShortest) + " s");
  std::vector<Stamp> steps;
  for (std::size_t i = 1; i < captured.size(); ++i) {
    steps.push_back(captured[i].stamp - captured[i - 1].stamp);
  }
  const double hole = kHole * ToSeconds(UpperMedian(std::move(steps)));
  std::vector<Node> nodes;
  std::size_t guesses = 0;
  for (Stamp stamp = begin; stamp <= end; stamp += FromSeconds(interval)) {
    const auto after = std::ranges::lower_bound(captured, stamp, {}, &StampedPose::stamp);
    const auto before = after == captured.begin() ? after : std::prev(after);
    const bool is_guess = after->stamp != stamp && ToSeconds(after->stamp - before->stamp) > hole;
    guesses += is_guess;
    nodes.push_back({stamp, Interpolate(captured, stamp).value(), is_guess});
  }
  const auto count = static_cast<double>(nodes.size());
  HIGHWALL_REQUIRE(static_cast<double>(guesses) <= (1.0 - kLeastCaptured) * count,
                   "more than half of the time has no captured pose");
  return nodes;
}

// Optimizes the states of all nodes in one graph.
class MotionFit {
 public:
  MotionFit(std::vector<Node> nodes, std::span<const ImuSample> readings,
            const RecordedMotionOptions& options)
      : options_(options), nodes_(std::move(nodes)) {
    for (const ImuSample& sample : readings) buffer_.Add(sample);
    states_.resize(nodes_.size());
    biases_.assign(nodes_.size(), ImuBias::Zero());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      states_[i].T_WB = nodes_[i].captured;
      const std::size_t before = i == 0 ? 0 : i - 1, after = std::min(i + 1, nodes_.size() - 1);
      states_[i].v_WB = (nodes_[after].captured.p() - nodes_[before].captured.p()) /
                        ToSeconds(nodes_[after].stamp - nodes_[before].stamp);
    }
  }

  // Solves from the current states; the readings are integrated with the current biases.
  void Solve() {
    FactorGraph graph;
    const auto gravity = graph.AddVariable(gravity_);
    std::vector<Variable<Pose>> poses;
    std::vector<Variable<Eigen::Vector3d>> velocities;
    std::vector<Variable<ImuBias>> biases;
    // Correlated errors count once per correlation time, not once per node.
    const double repeats = std::sqrt(2.0 * options_.error_lasts / options_.interval);
    Eigen::Matrix<double, 6, 1> weights;
    weights << Eigen::Vector3d::Constant(1.0 / (repeats * options_.position_sigma)),
        Eigen::Vector3d::Constant(1.0 / (repeats * options_.orientation_sigma));
    const Eigen::Matrix<double, 6, 6> W = weights.asDiagonal();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      poses.push_back(graph.AddVariable(states_[i].T_WB));
      velocities.push_back(graph.AddVariable(states_[i].v_WB));
      biases.push_back(graph.AddVariable(biases_[i]));
      if (!nodes_[i].is_guess) {
        graph.AddFactor(std::make_unique<PosePrior>(nodes_[i].captured, W), poses[i]);
      }
      if (i == 0) continue;
      const auto interval = buffer_.Between(nodes_[i - 1].stamp, nodes_[i].stamp);
      HIGHWALL_REQUIRE(interval && !interval->HasGap(), "the readings of the IMU have a gap");
      const ImuPreintegration imu(interval->samples, biases_[i - 1], {.noise = options_.noise});
      graph.AddFactor(std::make_unique<ImuGravityFactor>(imu), poses[i - 1], velocities[i - 1],
                      biases[i - 1], poses[i], velocities[i], biases[i], gravity);
    }
    const SolveSummary summary = graph.Solve({.linear_solver = LinearSolver::kSparseCholesky});
    HIGHWALL_REQUIRE(summary.IsUsable(), "motion and readings fit nothing: " + summary.message);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      states_[i] = {graph.Value(poses[i]), graph.Value(velocities[i])};
      biases_[i] = graph.Value(biases[i]);
    }
    gravity_ = graph.Value(gravity);
  }

  // Stores the motion in a world whose z is up.
  void Level(RecordedMotion* motion) const {
    const Eigen::Quaterniond q_UW =
        Eigen::Quaterniond::FromTwoVectors(gravity_.vector(), Eigen::Vector3d(0.0, 0.0, -1.0));
    motion->biases = biases_;
    for (const ImuState& state : states_) {
      motion->states.push_back(
          {Pose(q_UW * state.T_WB.q(), q_UW * state.T_WB.p()), q_UW * state.v_WB});
    }
    std::vector<double> positions, angles;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (nodes_[i].is_guess) continue;
      const Pose error = nodes_[i].captured.Inverse() * states_[i].T_WB;
      positions.push_back(error.p().norm());
      angles.push_back(so3::Log(error.q()).norm());
    }
    motion->consistency.position = UpperMedian(std::move(positions));
    motion->consistency.orientation = UpperMedian(std::move(angles));
  }

 private:
  RecordedMotionOptions options_;
  std::vector<Node> nodes_;
  ImuBuffer buffer_{{.max_step = 0.1, .horizon = 1e6}};
  std::vector<ImuState> states_;
  std::vector<ImuBias> biases_;
  UnitDirection gravity_;
};

// Compares the readings with the rates and accelerations of the spline.
void CompareReadings(RecordedMotion* motion) {
  const SplineTrajectory path = motion->PathOf(Pose(), 0);
  const double end = motion->interval * static_cast<double>(motion->states.size() - 1);
  std::vector<double> rates, forces;
  for (const ImuSample& sample : motion->readings) {
    const double t = ToSeconds(sample.stamp - motion->begin);
    if (t < kEnds || t > end - kEnds) continue;
    const CameraMotion at = path.MotionAt(t);
    const ImuBias& bias = motion->biases[static_cast<std::size_t>(t / motion->interval)];
    const Eigen::Vector3d f =
        at.T_WC.q().conjugate() * (at.a_WC + Eigen::Vector3d(0.0, 0.0, kStandardGravity));
    rates.push_back((sample.gyroscope - bias.head<3>() - at.w_C).norm());
    forces.push_back((sample.accelerometer - bias.tail<3>() - f).norm());
  }
  motion->consistency.gyroscope = UpperMedian(std::move(rates));
  motion->consistency.accelerometer = UpperMedian(std::move(forces));
}

}  // namespace

void RecordedMotionOptions::Validate() const {
  noise.Validate();
  RequirePositiveFinite(position_sigma, "RecordedMotionOptions::position_sigma");
  RequirePositiveFinite(orientation_sigma, "RecordedMotionOptions::orientation_sigma");
  RequirePositiveFinite(error_lasts, "RecordedMotionOptions::error_lasts");
  RequireWithin(interval, 1e-3, 0.5, "RecordedMotionOptions::interval");
}

SplineTrajectory RecordedMotion::PathOf(const Pose& T_BC, std::size_t first) const {
  const std::size_t count = states.size();
  std::vector<Pose> wanted(count);
  for (std::size_t i = 0; i < count; ++i) {
    wanted[i] = states[(first + i) % count].T_WB * T_BC;
  }
  // At t = i * interval the spline of control c is near c[i + 1].
  std::vector<Pose> control(count);
  for (std::size_t i = 0; i < count; ++i) control[(i + 1) % count] = wanted[i];
  const double period = interval * static_cast<double>(count);
  constexpr int kPasses = 30;  // each leaves at most two thirds of the residual
  for (int pass = 0; pass < kPasses; ++pass) {
    const SplineTrajectory spline(control, period);
    for (std::size_t i = 0; i < count; ++i) {
      const Pose at = spline.T_WC(interval * (static_cast<double>(i) + 1e-9));
      Pose& c = control[(i + 1) % count];
      c = Pose(c.q() * (at.q().conjugate() * wanted[i].q()), c.p() + wanted[i].p() - at.p());
    }
  }
  return SplineTrajectory(std::move(control), period);
}

RecordedMotion FitRecordedMotion(const Trajectory& captured, std::span<const ImuSample> readings,
                                 const RecordedMotionOptions& options) {
  options.Validate();
  HIGHWALL_REQUIRE(!captured.empty() && !readings.empty(), "there is no motion, or no reading");
  std::vector<Node> nodes = LayOutNodes(captured, readings, options.interval);
  RecordedMotion motion;
  motion.begin = nodes.front().stamp;
  motion.interval = options.interval;
  motion.readings.assign(readings.begin(), readings.end());
  MotionFit fit(std::move(nodes), readings, options);
  constexpr int kPasses = 2;  // the second with the biases of the first
  for (int pass = 0; pass < kPasses; ++pass) fit.Solve();
  fit.Level(&motion);
  HIGHWALL_REQUIRE(motion.consistency.orientation <= kWorstOrientation,
                   "captured turns are not those of the gyroscope: rad/s? the same recording?");
  CompareReadings(&motion);
  return motion;
}

}  // namespace highwall::simulate
