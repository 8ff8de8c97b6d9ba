#include "inertial/inertial_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

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
using Matrix18 = Eigen::Matrix<double, 18, 18>;

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

InertialEstimate Propagate(const InertialEstimate& from, const ImuPreintegration& imu,
                           const Eigen::Vector3d& gravity_W, double weight) {
  InertialEstimate to;
  to.stamp = imu.end();
  to.state = imu.Predict(from.state, from.bias, gravity_W);
  to.bias = from.bias;
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
  to.covariance = F * from.covariance * F.transpose() + Reordered(imu.covariance() / weight, R);
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

Matrix18 InertialPrior::Joint() const {
  Matrix18 joint;
  joint << estimate.covariance, coupling, coupling.transpose(), calibration_covariance;
  return joint;
}

void InertialPrior::SetJoint(const Matrix18& covariance) {
  estimate.covariance = covariance.topLeftCorner<15, 15>();
  coupling = covariance.topRightCorner<15, 3>();
  calibration_covariance = covariance.bottomRightCorner<3, 3>();
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
  Matrix18 J = Matrix18::Identity();  // in the tangent of a pose, rotations do not turn
  J.block<3, 3>(kP, kP) = J.block<3, 3>(kV, kV) = R;
  J.block<2, 2>(kN, kN) = UnitDirectionManifold::Basis(turned.gravity_W.data()).transpose() * R *
                          UnitDirectionManifold::Basis(gravity_W.data());
  turned.SetJoint(J * Joint() * J.transpose());
  return turned;
}

InertialWindow::InertialWindow(const ImuCalibration& calibration,
                               const SlidingWindowOptions& options, const InertialPrior& prior,
                               bool free_time_offset)
    : calibration_(calibration),
      smoother_(options),
      newest_(prior.estimate),
      free_time_offset_(free_time_offset),
      calibration_covariance_(prior.calibration_covariance),
      coupling_(prior.coupling) {
  gravity_ = smoother_.AddCalibration(prior.gravity_W);
  time_offset_ = smoother_.AddCalibration(prior.time_offset);
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
  std::vector<MarginalPrior::Block> blocks;
  const FactorGraph& graph = smoother_.graph();
  for (const VariableId& id : ids) {
    const double* block = graph.Block(id);
    blocks.push_back({{block, block + graph.problem().ParameterBlockSize(block)},
                      graph.problem().GetManifold(block)});
  }
  const Eigen::Index size = free_time_offset_ ? 18 : 17;
  const Eigen::MatrixXd A =
      SqrtInformation(Eigen::MatrixXd(prior.Joint().topLeftCorner(size, size)));
  smoother_.AddFactorToBlocks(
      std::make_shared<MarginalPrior>(std::move(blocks), A, Eigen::VectorXd::Zero(size)), nullptr,
      ids);
}

InertialWindow::State InertialWindow::AddState(const InertialEstimate& estimate) {
  return {smoother_.AddState(estimate.stamp, estimate.state.T_WB),
          smoother_.AddState(estimate.stamp, estimate.state.v_WB),
          smoother_.AddState(estimate.stamp, estimate.bias)};
}

bool InertialWindow::Add(const Step& step) {
  const Eigen::Vector3d gravity = kStandardGravity * gravity_W().vector();
  const InertialEstimate predicted = Propagate(newest_, *step.imu, gravity);
  const State before = state_;
  const State after = AddState(predicted);
  smoother_.AddFactor(std::make_unique<ImuGravityFactor>(*step.imu, kStandardGravity, step.weight),
                      before.pose, before.velocity, before.bias, after.pose, after.velocity,
                      after.bias, gravity_);
  if (step.visual != nullptr) {
    smoother_.AddFactor(
        std::make_unique<CameraPose>(step.visual->T_WC, step.visual->sqrt_information,
                                     calibration_.T_BC, step.omega_B, time_offset()),
        after.pose, after.velocity, time_offset_);
  }
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
  const std::array<VariableId, 5> ids = {state_.pose, state_.velocity, state_.bias, gravity_,
                                         time_offset_};
  const auto covariance = smoother_.Covariance(ids);
  if (!covariance) return;
  newest_.covariance = covariance->topLeftCorner<15, 15>();
  coupling_ = covariance->topRightCorner<15, 3>();
  calibration_covariance_ = covariance->bottomRightCorner<3, 3>();
}

InertialPrior InertialWindow::Prior() const {
  return {newest_, gravity_W(), time_offset(), calibration_covariance_, coupling_};
}

UnitDirection InertialWindow::gravity_W() const {
  return smoother_.Value(gravity_);
}

double InertialWindow::time_offset() const {
  return smoother_.Value(time_offset_);
}

}  // namespace highwall
