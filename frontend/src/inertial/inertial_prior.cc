#include "inertial/inertial_prior.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <highwall/core/so3.h>
#include <highwall/factors/imu_factor.h>

namespace highwall {
namespace {

// Columns of InertialEstimate::covariance, and of gravity's direction in InertialPrior::Joint().
using namespace state_rows;
using Matrix15 = Eigen::Matrix<double, 15, 15>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Reorders from the order of ImuPreintegration, [theta v p b], to that of InertialEstimate.
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

Twist CameraMotionBefore(const ImuPreintegration& imu, const ImuBias& bias,
                         const Eigen::Vector3d& gravity_W, const Pose& T_WB,
                         const Eigen::Vector3d& p_WB, const Pose& T_BC) {
  // docs/factors/imu_preintegration.md, Eq. 1: the position is linear in the first velocity.
  const ImuState from_rest = imu.Predict({T_WB}, bias, gravity_W);
  const Eigen::Vector3d v_WB = (p_WB - from_rest.T_WB.p()) / ToSeconds(imu.end() - imu.start());
  const Eigen::Vector3d omega_B = imu.samples().front().gyroscope - bias.head<3>();
  return CameraMotion({T_WB, v_WB}, omega_B, T_BC);
}

CameraPoseEstimate PredictCamera(const InertialPrior& from, const Pose& T_BC,
                                 const ImuPreintegration& imu, double weight) {
  const Eigen::Vector3d gravity = kStandardGravity * from.gravity_W.vector();
  const InertialEstimate body = Propagate(from.estimate, imu, gravity, weight);
  CameraPoseEstimate camera = CameraOf(body, T_BC);
  if (!from.T_BC) return camera;
  Matrix6 of_body = Matrix6::Identity(), of_T_BC = Matrix6::Identity();  // of the tangent of C
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

Matrix6 BodyByExtrinsics(const Pose& T_WB, const Pose& T_BC) {
  // T_WB = T_WC T_BC^-1.
  Matrix6 J = Matrix6::Zero();
  J.topLeftCorner<3, 3>() = -T_WB.R();
  J.topRightCorner<3, 3>() = -T_WB.R() * so3::Hat(T_BC.p()) * T_BC.R();
  J.bottomRightCorner<3, 3>() = -T_BC.R();
  return J;
}

bool InertialPrior::IsFinite() const {
  return estimate.state.T_WB.IsFinite() && estimate.state.v_WB.allFinite() &&
         estimate.bias.allFinite() && gravity_W.vector().allFinite() &&
         std::isfinite(time_offset) && (!T_BC || T_BC->IsFinite());
}

Eigen::MatrixXd InertialPrior::Joint() const {
  const Eigen::Index size = kN + calibration_covariance.rows();
  Eigen::MatrixXd joint(size, size);
  joint << estimate.covariance, coupling, coupling.transpose(), calibration_covariance;
  return joint;
}

Eigen::MatrixXd InertialPrior::JointWithoutTimeOffset() const {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < kN + calibration_covariance.rows(); ++i) {
    if (i != kN + 2) rows.push_back(i);
  }
  return Joint()(rows, rows);
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
  // The tangent of a pose is body-fixed in rotation and does not rotate with the world.
  Eigen::MatrixXd J = Eigen::MatrixXd::Identity(size, size);
  J.block<3, 3>(kP, kP) = J.block<3, 3>(kV, kV) = R;
  J.block<2, 2>(kN, kN) = UnitDirectionManifold::Basis(turned.gravity_W.data()).transpose() * R *
                          UnitDirectionManifold::Basis(gravity_W.data());
  turned.SetJoint(J * Joint() * J.transpose());
  return turned;
}

}  // namespace highwall
