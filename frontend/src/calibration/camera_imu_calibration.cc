#include <highwall/frontend/calibration/camera_imu_calibration.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include <ceres/loss_function.h>
#include <Eigen/Eigenvalues>

#include <highwall/core/error.h>
#include <highwall/core/factor_graph.h>
#include <highwall/core/prior.h>
#include <highwall/core/so3.h>
#include <highwall/factors/camera_pose.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/internal/require.h>

#include "calibration/axes_alignment.h"
#include "inertial/imu_saturation.h"

namespace highwall {
namespace {

using Scalar = Eigen::Matrix<double, 1, 1>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kShortest = 2.0;     // [s]
constexpr double kLeastTurn = 0.005;  // [rad] RMS between poses: 3 deg/s at 10 Hz
constexpr double kWorstTurns = 0.4;   // share of the rotations left as residuals at most
// Maximum residual RMS of the poses, [m] and [rad], and maximum scale of a valid calibration.
constexpr double kWorstPosition = 0.05, kWorstRotation = 0.05, kWorstScale = 1.5;
constexpr double kLeastSigma = 1e-5;       // [m], [rad] of a pose
constexpr double kGuessOfPosition = 3e-3;  // [m] initial sigma of a pose from images
constexpr double kGuessOfRotation = 3e-3;  // [rad]
// With larger sigmas a calibration should be recorded again.
constexpr double kGoodRotation = 0.3 * M_PI / 180.0;  // [rad]
constexpr double kGoodLeverArm = 0.005;               // [m]
constexpr double kGoodTimeOffset = 0.001;             // [s]
constexpr double kGoodScale = 0.01;

// Returns the poses at least `interval` apart, beginning with the first.
Trajectory Thinned(const Trajectory& all, double interval) {
  Trajectory some;
  for (const StampedPose& pose : all) {
    constexpr double kSlack = 1e-3;  // [s] for rounded stamps
    if (some.empty() || ToSeconds(pose.stamp - some.back().stamp) >= interval - kSlack) {
      some.push_back(pose);
    }
  }
  return some;
}

// Returns the poses connected by readings with the previous or the next one.
Trajectory WithReadingsBetween(const Trajectory& poses, const ImuBuffer& readings,
                               double time_offset, double max_interval) {
  const Stamp shift = FromSeconds(time_offset);
  std::vector<bool> tied(poses.size(), false);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Stamp a = poses[i - 1].stamp, b = poses[i].stamp;
    if (b <= a || ToSeconds(b - a) > max_interval) continue;
    const auto interval = readings.Between(a + shift, b + shift);
    if (interval && !interval->HasGap()) tied[i - 1] = tied[i] = true;
  }
  Trajectory some;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (tied[i]) some.push_back(poses[i]);
  }
  return some;
}

// The IMU without its extrinsics.
ImuCalibration Sensor(const CameraImuCalibrationOptions& options) {
  ImuCalibration sensor;
  sensor.noise = options.noise;
  sensor.gyroscope_range = options.gyroscope_range;
  sensor.accelerometer_range = options.accelerometer_range;
  return sensor;
}

// Current estimate.
struct Estimate {
  Pose T_BC;
  double time_offset = 0.0, depth_scale = 1.0;
  UnitDirection gravity;
  std::vector<ImuState> states;
  std::vector<ImuBias> biases;
};

// Residuals of the poses in temporal order.
struct Residuals {
  std::vector<Vector6> of_poses;  // [m] in W, [rad]

  double Rms(int first) const {
    double sum = 0.0;
    for (const Vector6& e : of_poses) sum += e.segment<3>(first).squaredNorm();
    return std::sqrt(sum / (3.0 * static_cast<double>(of_poses.size())));
  }
  // Returns the correlation of neighbours: map errors persist, so that ten poses a second are not
  // ten independent measurements.
  double Correlation(int first) const {
    double sum = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < of_poses.size(); ++i) {
      squares += of_poses[i].segment<3>(first).squaredNorm();
      if (i > 0) sum += of_poses[i].segment<3>(first).dot(of_poses[i - 1].segment<3>(first));
    }
    return squares > 0.0 ? std::clamp(sum / squares, 0.0, 0.95) : 0.0;
  }
};

struct Covariances {
  Matrix6 T_BC;
  double time_offset = 0.0, depth_scale = 0.0;
  ImuBias bias;
};

// Problem of one round: readings cut at the offset, and integrated at the biases, of the estimate.
class CalibrationGraph {
 public:
  CalibrationGraph(const Trajectory& camera, const ImuBuffer& readings, const Estimate& estimate,
                   const CameraImuCalibrationOptions& options)
      : camera_(camera), readings_(readings), from_(estimate), options_(options) {
    T_BC_ = graph_.AddVariable(estimate.T_BC);
    time_offset_ = graph_.AddVariable(estimate.time_offset);
    depth_scale_ = graph_.AddVariable(estimate.depth_scale);
    gravity_ = graph_.AddVariable(estimate.gravity);
    AddPriors();
  }

  // sigmas: of a pose [m], [rad].
  void Build(double position_sigma, double rotation_sigma) {
    Vector6 weights;
    weights << Eigen::Vector3d::Constant(1.0 / position_sigma),
        Eigen::Vector3d::Constant(1.0 / rotation_sigma);
    const auto loss = std::make_shared<ceres::HuberLoss>(std::sqrt(16.8));  // 99 % of 6 dof
    for (std::size_t i = 0; i < camera_.size(); ++i) {
      states_.push_back({graph_.AddVariable(from_.states[i].T_WB),
                         graph_.AddVariable(from_.states[i].v_WB),
                         graph_.AddVariable(from_.biases[i])});
      const State& state = states_.back();
      graph_.AddFactor(
          std::make_unique<ExtrinsicCameraPose>(camera_[i].pose, Matrix6(weights.asDiagonal()),
                                                RateAt(i), from_.time_offset),
          loss, state.pose, state.velocity, time_offset_, T_BC_, depth_scale_);
      if (!AddImuFactor(i)) AddPriorsOf(state);
    }
  }

  // Returns the reason why there is no solution; empty if there is one.
  std::string Solve(Estimate* estimate) {
    const SolveSummary summary =
        graph_.Solve({.max_iterations = 30, .linear_solver = LinearSolver::kSparseCholesky});
    if (!summary.IsUsable()) return "calibration failed: " + summary.message;
    estimate->T_BC = graph_.Value(T_BC_);
    estimate->time_offset = graph_.Value(time_offset_);
    estimate->depth_scale = graph_.Value(depth_scale_);
    estimate->gravity = graph_.Value(gravity_);
    for (std::size_t i = 0; i < states_.size(); ++i) {
      estimate->states[i] = {graph_.Value(states_[i].pose), graph_.Value(states_[i].velocity)};
      estimate->biases[i] = graph_.Value(states_[i].bias);
    }
    return "";
  }

  Residuals PoseResiduals() const {
    Residuals residuals;
    const double d = graph_.Value(time_offset_) - from_.time_offset;
    const Pose T_BC = graph_.Value(T_BC_);
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const Pose T_WB = graph_.Value(states_[i].pose);
      const Pose moved(T_WB.q() * so3::Exp(d * RateAt(i)),
                       T_WB.p() + d * graph_.Value(states_[i].velocity));
      const Pose T_WC = moved * T_BC;
      Vector6 e;
      e << T_WC.p() / graph_.Value(depth_scale_) - camera_[i].pose.p(),
          so3::Log(camera_[i].pose.q().conjugate() * T_WC.q());
      residuals.of_poses.push_back(e);
    }
    return residuals;
  }

  // Empty if the solution is not determined, by the variable that Undetermined() names.
  std::optional<Covariances> Covariance() const {
    const State& middle = states_[states_.size() / 2];
    const std::array<VariableId, 4> ids = {T_BC_, time_offset_, depth_scale_, middle.bias};
    const auto determined = graph_.Covariance(ids);
    if (!determined) return std::nullopt;
    const Eigen::MatrixXd& P = *determined;
    return Covariances{.T_BC = P.topLeftCorner<6, 6>(),
                       .time_offset = P(6, 6),
                       .depth_scale = P(7, 7),
                       .bias = P.diagonal().segment<6>(8)};
  }
  std::string Undetermined() const { return graph_.Undetermined(); }

 private:
  struct State {
    Variable<Pose> pose;
    Variable<Eigen::Vector3d> velocity;
    Variable<ImuBias> bias;
  };

  void AddPriors() {
    Vector6 weights;  // the rotation has no other prior: 1 rad
    weights << Eigen::Vector3d::Constant(1.0 / options_.lever_arm_sigma),
        Eigen::Vector3d::Constant(1.0);
    graph_.AddFactor(std::make_unique<PosePrior>(Pose(from_.T_BC.q(), Eigen::Vector3d::Zero()),
                                                 Matrix6(weights.asDiagonal())),
                     T_BC_);
    graph_.AddFactor(
        std::make_unique<VectorPrior<1>>(Scalar(0.0), Scalar(1.0 / options_.max_time_offset)),
        time_offset_);
    if (!options_.estimate_depth_scale) graph_.Fix(depth_scale_);
    graph_.AddFactor(
        std::make_unique<VectorPrior<1>>(Scalar(1.0), Scalar(1.0 / options_.depth_scale_sigma)),
        depth_scale_);
  }

  // Priors on velocity and bias, which may be unobservable if no readings lead to a state.
  void AddPriorsOf(const State& state) {
    constexpr double kFastest = 10.0;  // [m/s]
    Vector6 weights;
    weights << Eigen::Vector3d::Constant(1.0 / options_.gyroscope_bias_sigma),
        Eigen::Vector3d::Constant(1.0 / options_.accelerometer_bias_sigma);
    graph_.AddFactor(
        std::make_unique<VectorPrior<6>>(Vector6(Vector6::Zero()), Matrix6(weights.asDiagonal())),
        state.bias);
    graph_.AddFactor(
        std::make_unique<VectorPrior<3>>(Eigen::Vector3d(Eigen::Vector3d::Zero()),
                                         Eigen::Matrix3d(Eigen::Matrix3d::Identity() / kFastest)),
        state.velocity);
  }

  Stamp ImuStamp(std::size_t i) const { return camera_[i].stamp + FromSeconds(from_.time_offset); }

  // Returns the mean of the surrounding readings over 20 ms, bias removed.
  Eigen::Vector3d RateAt(std::size_t i) const {
    constexpr double kHalf = 0.01;  // [s]
    const auto interval =
        readings_.Between(ImuStamp(i) - FromSeconds(kHalf), ImuStamp(i) + FromSeconds(kHalf));
    if (!interval) return Eigen::Vector3d::Zero();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const ImuSample& sample : interval->samples) sum += sample.gyroscope;
    return sum / static_cast<double>(interval->samples.size()) - from_.biases[i].head<3>();
  }

  // Adds an IMU factor for the readings since the previous pose, if there are any.
  bool AddImuFactor(std::size_t i) {
    if (i == 0) return false;
    if (ToSeconds(camera_[i].stamp - camera_[i - 1].stamp) > options_.max_interval) return false;
    const auto interval = readings_.Between(ImuStamp(i - 1), ImuStamp(i));
    if (!interval || interval->HasGap()) return false;
    const State &a = states_[i - 1], &b = states_[i];
    const ImuNoise noise = SaturatedNoise(options_.noise, interval->samples, Sensor(options_));
    graph_.AddFactor(std::make_unique<ImuGravityFactor>(ImuPreintegration(
                         interval->samples, from_.biases[i - 1], {.noise = noise})),
                     a.pose, a.velocity, a.bias, b.pose, b.velocity, b.bias, gravity_);
    return true;
  }

  const Trajectory& camera_;
  const ImuBuffer& readings_;
  const Estimate from_;
  const CameraImuCalibrationOptions& options_;
  FactorGraph graph_;
  Variable<Pose> T_BC_;
  Variable<double> time_offset_, depth_scale_;
  Variable<UnitDirection> gravity_;
  std::vector<State> states_;
};

// Initial guess: camera poses transformed to the body, velocities by differences, gravity by the
// accelerometer. Empty if its readings are zero.
std::optional<Estimate> FirstEstimate(const Trajectory& camera, const ImuBuffer& readings,
                                      const AxesAlignment& axes) {
  Estimate estimate{.T_BC = Pose(axes.q_BC, Eigen::Vector3d::Zero()),
                    .time_offset = axes.time_offset,
                    .depth_scale = 1.0,
                    .gravity = UnitDirection(),
                    .states = {},
                    .biases = {}};
  ImuBias bias;
  bias << axes.gyroscope_bias, Eigen::Vector3d::Zero();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < camera.size(); ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1, after = std::min(i + 1, camera.size() - 1);
    const double time = ToSeconds(camera[after].stamp - camera[before].stamp);
    estimate.states.push_back({camera[i].pose * estimate.T_BC.Inverse(),
                               (camera[after].pose.p() - camera[before].pose.p()) / time});
    estimate.biases.push_back(bias);
    const Stamp stamp = camera[i].stamp + FromSeconds(axes.time_offset);
    if (const auto around =
            readings.Between(stamp - FromSeconds(0.05), stamp + FromSeconds(0.05))) {
      for (const ImuSample& sample : around->samples) {
        force += estimate.states[i].T_WB.q() * sample.accelerometer /
                 static_cast<double>(around->samples.size());
      }
    }
  }
  if (!(force.norm() > 0.0)) return std::nullopt;
  estimate.gravity = UnitDirection(Eigen::Vector3d(-force));
  return estimate;
}

// Returns the axis nearest to the principal direction of P if its standard deviation exceeds
// `limit`.
std::optional<int> WorstAxis(const Eigen::Matrix3d& P, double limit) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(P);
  if (std::sqrt(axes.eigenvalues()[2]) <= limit) return std::nullopt;
  Eigen::Index axis = 0;
  axes.eigenvectors().col(2).cwiseAbs().maxCoeff(&axis);
  return static_cast<int>(axis);
}

std::vector<std::string> Advice(const CameraImuCalibration& result, const Matrix6& P,
                                bool with_scale) {
  std::vector<std::string> advice;
  // A rotation about an axis gives no information on the extrinsic rotation about that axis.
  constexpr const char* kRotation[] = {
      "pitch (about the camera's x) is hardly observable: turn it left and right, and roll it",
      "yaw (about the camera's y) is hardly observable: tilt it up and down, and roll it",
      "roll about the optical axis is hardly observable: turn it left and right, up and down"};
  constexpr const char* kLeverArm[] = {
      "the lever arm along the IMU's x is hardly observable: turn faster about its y and z",
      "the lever arm along the IMU's y is hardly observable: turn faster about its x and z",
      "the lever arm along the IMU's z is hardly observable: turn faster about its x and y"};
  if (const auto axis = WorstAxis(P.bottomRightCorner<3, 3>(), kGoodRotation)) {
    advice.emplace_back(kRotation[*axis]);
  }
  if (const auto axis = WorstAxis(P.topLeftCorner<3, 3>(), kGoodLeverArm)) {
    advice.emplace_back(kLeverArm[*axis]);
  }
  if (result.time_offset_sigma > kGoodTimeOffset) {
    advice.emplace_back(
        "the time offset is not known to a millisecond: turn faster, back and forth");
  }
  if (with_scale && result.depth_scale_sigma > kGoodScale) {
    advice.emplace_back(
        "the depth scale is not known to a percent: move by a metre and back, in a second or two");
  }
  return advice;
}

}  // namespace

void CameraImuCalibrationOptions::Validate() const {
  Sensor(*this).Validate();
  RequirePositiveFinite(interval, "CameraImuCalibrationOptions::interval");
  HIGHWALL_REQUIRE(max_interval > interval,
                   "CameraImuCalibrationOptions::max_interval must be above interval");
  RequirePositiveFinite(max_time_offset, "CameraImuCalibrationOptions::max_time_offset");
  RequirePositiveFinite(lever_arm_sigma, "CameraImuCalibrationOptions::lever_arm_sigma");
  RequirePositiveFinite(depth_scale_sigma, "CameraImuCalibrationOptions::depth_scale_sigma");
  RequirePositiveFinite(gyroscope_bias_sigma, "CameraImuCalibrationOptions::gyroscope_bias_sigma");
  RequirePositiveFinite(accelerometer_bias_sigma,
                        "CameraImuCalibrationOptions::accelerometer_bias_sigma");
}

namespace {

// Solves from the initial guess on. Returns the reason why that failed; empty if it did not.
std::string Refine(const Trajectory& poses, const ImuBuffer& buffer,
                   const CameraImuCalibrationOptions& options, Estimate estimate,
                   CameraImuCalibration* calibration) {
  CameraImuCalibration& result = *calibration;
  double position_sigma = kGuessOfPosition, rotation_sigma = kGuessOfRotation;
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    CalibrationGraph graph(poses, buffer, estimate, options);
    graph.Build(position_sigma, rotation_sigma);
    const std::string fault = graph.Solve(&estimate);
    if (!fault.empty()) return fault;
    const Residuals residuals = graph.PoseResiduals();
    result.position_error = residuals.Rms(0);
    result.rotation_error = residuals.Rms(3);
    // Inflated for correlated errors.
    const auto inflated = [&](int first) {
      const double rho = residuals.Correlation(first);
      return std::max(kLeastSigma, residuals.Rms(first) * std::sqrt((1.0 + rho) / (1.0 - rho)));
    };
    position_sigma = inflated(0);
    rotation_sigma = inflated(3);
    if (round + 1 < kRounds) continue;
    const std::optional<Covariances> P = graph.Covariance();
    if (!P) return "calibration failed: " + graph.Undetermined();
    result.lever_arm_sigma = P->T_BC.diagonal().head<3>().cwiseSqrt();
    result.rotation_sigma = P->T_BC.diagonal().tail<3>().cwiseSqrt();
    result.time_offset_sigma = std::sqrt(P->time_offset);
    result.depth_scale_sigma = std::sqrt(P->depth_scale);
    result.bias_sigma = P->bias.cwiseSqrt();
    result.advice = Advice(result, P->T_BC, options.estimate_depth_scale);
  }
  const bool is_motion_of_imu =
      result.position_error <= kWorstPosition && result.rotation_error <= kWorstRotation &&
      estimate.depth_scale <= kWorstScale && estimate.depth_scale >= 1.0 / kWorstScale;
  if (!is_motion_of_imu) {
    return "the motion of the camera is not that of the accelerometer: its sign? m/s^2? "
           "depth_factor? readings that end where it does (imu: accelerometer_range)?";
  }
  result.T_BC = estimate.T_BC;
  result.time_offset = estimate.time_offset;
  result.depth_scale = estimate.depth_scale;
  result.bias = estimate.biases[estimate.biases.size() / 2];
  result.poses = static_cast<int>(poses.size());
  return "";
}

}  // namespace

std::optional<CameraImuCalibration> CalibrateCameraImu(const Trajectory& camera,
                                                       std::span<const ImuSample> readings,
                                                       const CameraImuCalibrationOptions& options,
                                                       std::string* reason) {
  options.Validate();
  const auto fail = [reason](const std::string& why) {
    if (reason != nullptr) *reason = why;
    return std::nullopt;
  };
  const Trajectory thinned = Thinned(camera, options.interval);
  ImuBuffer buffer({.max_step = 0.1, .horizon = 1e9});
  for (const ImuSample& sample : readings) buffer.Add(sample);
  const std::optional<AxesAlignment> axes = AlignAxes(
      thinned, buffer, options.max_time_offset, options.max_interval, options.gyroscope_range);
  if (!axes) return fail("camera and readings share fewer than 8 motions: other clocks?");
  const Trajectory poses =
      WithReadingsBetween(thinned, buffer, axes->time_offset, options.max_interval);
  if (!(static_cast<double>(poses.size()) * options.interval >= kShortest)) {
    return fail("camera and readings share less than two seconds");
  }
  if (!(axes->excitation >= kLeastTurn)) {
    return fail("the motion turns about one axis at most: turn the camera about all three");
  }
  if (!(axes->error <= kWorstTurns * axes->excitation)) {
    return fail(
        "the turns of the camera are not those of the gyroscope: rad/s? the same recording? clocks "
        "that are less than 0.2 s apart?");
  }
  const std::optional<Estimate> first = FirstEstimate(poses, buffer, *axes);
  if (!first) return fail("no accelerometer: its readings are zero");
  CameraImuCalibration result;
  const std::string fault = Refine(poses, buffer, options, *first, &result);
  if (!fault.empty()) return fail(fault);
  if (reason != nullptr) reason->clear();
  return result;
}

}  // namespace highwall
