#include "inertial/inertial_window.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <ceres/problem.h>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/marginalization.h>
#include <highwall/core/so3.h>
#include <highwall/core/sqrt_information.h>
#include <highwall/factors/camera_pose.h>
#include <highwall/factors/imu_factor.h>
#include <highwall/factors/zero_velocity.h>

namespace highwall {
namespace {

// Columns of InertialEstimate::covariance, and of gravity's direction in InertialPrior::Joint().
constexpr int kP = 0, kTheta = 3, kV = 6, kB = 9, kN = 15;
using Matrix15 = Eigen::Matrix<double, 15, 15>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// From the order of ImuPreintegration, [theta v p b], to that of InertialEstimate.
Matrix15 Reordered(const Matrix15& imu, const Eigen::Matrix3d& R_WB) {
  Matrix15 G = Matrix15::Zero();
  G.block<3, 3>(kTheta, 0).setIdentity();
  G.block<3, 3>(kV, 3) = R_WB;
  G.block<3, 3>(kP, 6) = R_WB;
  G.block<6, 6>(kB, 9).setIdentity();
  return G * imu * G.transpose();
}

}  // namespace

Matrix15 Transition(const InertialEstimate& from, const ImuPreintegration& imu) {
  const ImuDelta& delta = imu.delta();
  const ImuDelta::Motion motion = delta.At(from.bias);
  const Eigen::Matrix3d R = from.state.T_WB.R();
  Matrix15 F = Matrix15::Identity();
  F.block<3, 3>(kTheta, kTheta) = motion.q.conjugate().toRotationMatrix();
  F.block<3, 6>(kTheta, kB) = delta.bias_jacobian.topRows<3>();
  F.block<3, 3>(kV, kTheta) = -R * so3::Hat(motion.v);
  F.block<3, 6>(kV, kB) = R * delta.bias_jacobian.middleRows<3>(3);
  F.block<3, 3>(kP, kTheta) = -R * so3::Hat(motion.p);
  F.block<3, 3>(kP, kV) = delta.duration * Eigen::Matrix3d::Identity();
  F.block<3, 6>(kP, kB) = R * delta.bias_jacobian.bottomRows<3>();
  return F;
}

InertialEstimate Propagate(const InertialEstimate& from, const ImuPreintegration& imu,
                           const Eigen::Vector3d& gravity_W, double weight) {
  InertialEstimate to;
  to.stamp = imu.end();
  to.state = imu.Predict(from.state, from.bias, gravity_W);
  to.bias = from.bias;
  const Matrix15 F = Transition(from, imu);
  to.covariance = F * from.covariance * F.transpose() +
                  Reordered(imu.covariance() / weight, from.state.T_WB.R());
  to.covariance = 0.5 * (to.covariance + to.covariance.transpose()).eval();
  return to;
}

CameraPoseEstimate CameraOf(const InertialEstimate& body, const Pose& T_BC) {
  const Eigen::Matrix3d R = body.state.T_WB.R();
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.topRightCorner<3, 3>() = -R * so3::Hat(T_BC.p());
  J.bottomRightCorner<3, 3>() = T_BC.R().transpose();
  return {body.state.T_WB * T_BC, J * body.covariance.topLeftCorner<6, 6>() * J.transpose()};
}

Twist CameraMotion(const ImuState& body, const Eigen::Vector3d& omega_B, const Pose& T_BC) {
  const Eigen::Quaterniond q_CB = T_BC.q().conjugate();
  const Eigen::Vector3d v_B = body.T_WB.q().conjugate() * body.v_WB + omega_B.cross(T_BC.p());
  return {q_CB * v_B, q_CB * omega_B};
}

CameraPoseEstimate PredictCamera(const InertialPrior& from, const Pose& T_BC,
                                 const ImuPreintegration& imu, double weight) {
  const Eigen::Vector3d gravity = kStandardGravity * from.gravity_W.vector();
  const InertialEstimate body = Propagate(from.estimate, imu, gravity, weight);
  CameraPoseEstimate camera = CameraOf(body, T_BC);
  if (!from.T_BC) return camera;
  Matrix6 of_body = Matrix6::Identity(), of_T_BC = Matrix6::Identity();  // of the camera's tangent
  of_body.topRightCorner<3, 3>() = -body.state.T_WB.R() * so3::Hat(T_BC.p());
  of_body.bottomRightCorner<3, 3>() = T_BC.R().transpose();
  of_T_BC.topLeftCorner<3, 3>() = body.state.T_WB.R();
  const Matrix6 coupling =
      (Transition(from.estimate, imu) * from.coupling.rightCols<6>()).topRows<6>();
  const Matrix6 both = of_body * coupling * of_T_BC.transpose();
  camera.covariance +=
      both + both.transpose() +
      of_T_BC * from.calibration_covariance.bottomRightCorner<6, 6>() * of_T_BC.transpose();
  return camera;
}

Eigen::MatrixXd InertialPrior::Joint() const {
  const Eigen::Index size = kN + calibration_covariance.rows();
  Eigen::MatrixXd joint(size, size);
  joint << estimate.covariance, coupling, coupling.transpose(), calibration_covariance;
  return joint;
}

void InertialPrior::SetJoint(const Eigen::MatrixXd& covariance) {
  const Eigen::Index size = covariance.rows() - kN;
  estimate.covariance = covariance.topLeftCorner<kN, kN>();
  coupling = covariance.topRightCorner(kN, size);
  calibration_covariance = covariance.bottomRightCorner(size, size);
}

double InertialPrior::gravity_sigma() const {
  return std::sqrt(calibration_covariance.diagonal().head<2>().maxCoeff());
}

double InertialPrior::time_offset_sigma() const {
  return std::sqrt(std::max(calibration_covariance(2, 2), 0.0));
}

InertialPrior InertialPrior::Turned(const Eigen::Quaterniond& q) const {
  InertialPrior turned = *this;
  turned.estimate.state.T_WB = Pose(q, Eigen::Vector3d::Zero()) * estimate.state.T_WB;
  turned.estimate.state.v_WB = q * estimate.state.v_WB;
  turned.gravity_W = UnitDirection(q * gravity_W.vector());
  const Eigen::Matrix3d R = q.toRotationMatrix();
  const Eigen::Index size = kN + calibration_covariance.rows();
  // In the tangent of a pose, rotations do not turn.
  Eigen::MatrixXd J = Eigen::MatrixXd::Identity(size, size);
  J.block<3, 3>(kP, kP) = J.block<3, 3>(kV, kV) = R;
  J.block<2, 2>(kN, kN) = UnitDirectionManifold::Basis(turned.gravity_W.data()).transpose() * R *
                          UnitDirectionManifold::Basis(gravity_W.data());
  turned.SetJoint(J * Joint() * J.transpose());
  return turned;
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
  AddPrior(prior);
  const UpdateReport report = smoother_.Update();
  HIGHWALL_REQUIRE(report.accepted, "InertialWindow: the prior was refused: " + report.message);
  ReadNewest(prior.estimate.stamp);
}

void InertialWindow::AddPrior(const InertialPrior& prior) {
  std::vector<VariableId> ids = {state_.pose, state_.velocity, state_.bias, gravity_};
  if (free_time_offset_) ids.push_back(time_offset_);
  if (extrinsics_) ids.push_back(extrinsics_->T_BC);
  std::vector<MarginalPrior::Block> blocks;
  const FactorGraph& graph = smoother_.graph();
  for (const VariableId& id : ids) {
    const double* block = graph.Block(id);
    blocks.push_back({{block, block + graph.problem().ParameterBlockSize(block)},
                      graph.problem().GetManifold(block)});
  }
  std::vector<Eigen::Index> rows;  // of t_d none, where it is known
  for (Eigen::Index i = 0; i < kN + prior.calibration_covariance.rows(); ++i) {
    if (i != kN + 2 || free_time_offset_) rows.push_back(i);
  }
  const auto size = static_cast<Eigen::Index>(rows.size());
  const Eigen::MatrixXd A = SqrtInformation(Eigen::MatrixXd(prior.Joint()(rows, rows)));
  smoother_.AddFactorToBlocks(
      std::make_shared<MarginalPrior>(std::move(blocks), A, Eigen::VectorXd::Zero(size)), nullptr,
      ids);
}

InertialWindow::State InertialWindow::AddState(const InertialEstimate& estimate) {
  return {smoother_.AddState(estimate.stamp, estimate.state.T_WB),
          smoother_.AddState(estimate.stamp, estimate.state.v_WB),
          smoother_.AddState(estimate.stamp, estimate.bias)};
}

void InertialWindow::AddVisual(const Step& step, const State& state) {
  const auto& [T_WC, sqrt_information] = *step.visual;
  if (extrinsics_) {
    smoother_.AddFactor(
        std::make_unique<ExtrinsicCameraPose>(T_WC, sqrt_information, step.omega_B, time_offset()),
        state.pose, state.velocity, time_offset_, extrinsics_->T_BC, extrinsics_->scale);
  } else {
    smoother_.AddFactor(
        std::make_unique<CameraPose>(T_WC, sqrt_information, T_BC_, step.omega_B, time_offset()),
        state.pose, state.velocity, time_offset_);
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
