#include "inertial/inertial_window.h"

#include <memory>
#include <utility>
#include <vector>

#include <highwall/factors/camera_pose.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/zero_velocity.h>

#include "inertial/joint_prior.h"

namespace highwall {
namespace {

using state_rows::kN;

}  // namespace

std::optional<InertialWindow> InertialWindow::Make(const ImuCalibration& calibration,
                                                   const SlidingWindowOptions& options,
                                                   const InertialPrior& prior,
                                                   bool free_time_offset) {
  if (!prior.IsFinite()) return std::nullopt;
  InertialWindow window(calibration, options, prior, free_time_offset);
  if (!window.Begin(prior)) return std::nullopt;
  return window;
}

InertialWindow::InertialWindow(const ImuCalibration& calibration,
                               const SlidingWindowOptions& options, const InertialPrior& prior,
                               bool free_time_offset)
    : smoother_(options),
      T_BC_(prior.T_BC.value_or(calibration.T_BC)),
      newest_(prior.estimate),
      free_time_offset_(free_time_offset),
      calibration_covariance_(prior.calibration_covariance),
      coupling_(prior.coupling) {
  gravity_ = smoother_.AddCalibration(prior.gravity_W);
  time_offset_ = smoother_.AddCalibration(prior.time_offset);
  if (prior.T_BC) {
    extrinsics_ = {smoother_.AddCalibration(T_BC_), smoother_.AddCalibration(1.0)};
    smoother_.Fix(extrinsics_->scale);
  }
  state_ = AddState(prior.estimate);
  if (!free_time_offset) smoother_.Fix(time_offset_);
}

bool InertialWindow::Begin(const InertialPrior& prior) {
  if (!AddPrior(prior) || !smoother_.Update().accepted) return false;
  ReadNewest(prior.estimate.stamp);
  return true;
}

bool InertialWindow::AddPrior(const InertialPrior& prior) {
  std::vector<VariableId> ids = {state_.pose, state_.velocity, state_.bias, gravity_};
  if (free_time_offset_) ids.push_back(time_offset_);
  if (extrinsics_) ids.push_back(extrinsics_->T_BC);
  return AddJointPrior(free_time_offset_ ? prior.Joint() : prior.JointWithoutTimeOffset(), ids,
                       &smoother_);
}

InertialWindow::State InertialWindow::AddState(const InertialEstimate& estimate) {
  return {smoother_.AddState(estimate.stamp, estimate.state.T_WB),
          smoother_.AddState(estimate.stamp, estimate.state.v_WB),
          smoother_.AddState(estimate.stamp, estimate.bias)};
}

void InertialWindow::AddVisual(const Step& step, const State& state) {
  const auto& [T_WC, sqrt_information] = *step.visual;
  const double t_d = step.time_offset.value_or(time_offset());
  if (extrinsics_) {
    smoother_.AddFactor(
        std::make_unique<ExtrinsicCameraPose>(T_WC, sqrt_information, step.omega_B, t_d),
        state.pose, state.velocity, time_offset_, extrinsics_->T_BC, extrinsics_->scale);
  } else {
    smoother_.AddFactor(
        std::make_unique<CameraPose>(T_WC, sqrt_information, T_BC_, step.omega_B, t_d), state.pose,
        state.velocity, time_offset_);
  }
}

bool InertialWindow::Add(const Step& step) {
  const Eigen::Vector3d gravity = kStandardGravity * gravity_W().vector();
  const InertialEstimate predicted = Propagate(newest_, *step.imu, gravity);
  const State before = state_;
  const State after = AddState(predicted);
  smoother_.AddFactor(std::make_unique<ImuGravityFactor>(*step.imu, kStandardGravity, step.weight),
                      before.pose, before.velocity, before.bias, after.pose, after.velocity,
                      after.bias, gravity_);
  if (step.visual != nullptr) AddVisual(step, after);
  if (step.stationary) smoother_.AddFactor(std::make_unique<ZeroVelocity>(), after.velocity);
  if (!smoother_.Update().accepted) return false;
  state_ = after;
  ReadNewest(predicted.stamp);
  return true;
}

void InertialWindow::ReadNewest(Stamp stamp) {
  newest_.stamp = stamp;
  newest_.state.T_WB = smoother_.Value(state_.pose);
  newest_.state.v_WB = smoother_.Value(state_.velocity);
  newest_.bias = smoother_.Value(state_.bias);
  std::vector<VariableId> ids = {state_.pose, state_.velocity, state_.bias, gravity_, time_offset_};
  if (extrinsics_) {
    T_BC_ = smoother_.Value(extrinsics_->T_BC);
    ids.push_back(extrinsics_->T_BC);
  }
  const auto covariance = smoother_.Covariance(ids);
  if (!covariance) return;
  const Eigen::Index size = covariance->rows() - kN;
  newest_.covariance = covariance->topLeftCorner<kN, kN>();
  coupling_ = covariance->topRightCorner(kN, size);
  calibration_covariance_ = covariance->bottomRightCorner(size, size);
}

InertialPrior InertialWindow::Prior() const {
  const std::optional<Pose> T_BC = extrinsics_ ? std::optional(T_BC_) : std::nullopt;
  return {newest_, gravity_W(), time_offset(), T_BC, calibration_covariance_, coupling_};
}

UnitDirection InertialWindow::gravity_W() const {
  return smoother_.Value(gravity_);
}

double InertialWindow::time_offset() const {
  return smoother_.Value(time_offset_);
}

}  // namespace highwall
