#include <highwall/factors/imu_factor.h>

#include <cmath>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>
#include <highwall/core/sqrt_information.h>
#include <highwall/internal/require.h>

namespace highwall {
namespace {

constexpr int kTheta = 0, kV = 3, kP = 6;  // rows of r; the biases follow

template <int kCols>
using Columns = Eigen::Matrix<double, 15, kCols>;
using ConstVector3 = Eigen::Map<const Eigen::Vector3d>;
using ConstQuaternion = Eigen::Map<const Eigen::Quaterniond>;
using ConstBias = Eigen::Map<const ImuBias>;

// States at both ends and quantities shared by the residual and the Jacobians.
class Linearization {
 public:
  Linearization(const ImuMeasurement& measurement, double const* const* blocks,
                const Eigen::Vector3d& gravity_W)
      : measurement_(measurement), delta_(measurement.delta), blocks_(blocks) {
    const ConstVector3 p_i(blocks[0]), v_i(blocks[1]), p_j(blocks[3]), v_j(blocks[4]);
    const ConstQuaternion q_i(blocks[0] + 3), q_j(blocks[3] + 3);
    const ConstBias b_i(blocks[2]), b_j(blocks[5]);
    const double T = delta_.duration;
    const Eigen::Matrix<double, 9, 1> shift = delta_.bias_jacobian * (b_i - delta_.bias);
    R_iT_ = q_i.toRotationMatrix().transpose();
    q_ij_ = q_i.conjugate() * q_j;
    v_ij_ = R_iT_ * (v_j - v_i - T * gravity_W);
    p_ij_ = R_iT_ * (p_j - p_i - T * v_i - 0.5 * T * T * gravity_W);
    shift_theta_ = shift.head<3>();
    theta_ = so3::Log((delta_.q * so3::Exp(shift_theta_)).conjugate() * q_ij_);
    // Eq. 1
    e_ << theta_, v_ij_ - delta_.v - shift.segment<3>(3), p_ij_ - delta_.p - shift.tail<3>(),
        b_j - b_i;
  }

  bool IsFinite() const { return e_.allFinite(); }
  void WriteResidual(double* residuals) const {
    Eigen::Map<Eigen::Matrix<double, 15, 1>> r(residuals);
    r.noalias() = measurement_.W.triangularView<Eigen::Lower>() * e_;
  }

  // Eq. 2 to 7. jacobians: six pointers, each of which may be null.
  void WriteJacobians(double** jacobians) const {
    const Eigen::Matrix3d J_theta = so3::RightJacobianInverse(theta_);
    const double T = delta_.duration;
    if (jacobians[0] != nullptr) {
      Columns<6> J = Columns<6>::Zero();
      J.block<3, 3>(kP, 0) = -R_iT_;
      J.block<3, 3>(kTheta, 3) = -J_theta * q_ij_.conjugate().toRotationMatrix();
      J.block<3, 3>(kV, 3) = so3::Hat(v_ij_);
      J.block<3, 3>(kP, 3) = so3::Hat(p_ij_);
      PoseManifold::Lift<15>(blocks_[0], Whiten(J), jacobians[0]);
    }
    if (jacobians[1] != nullptr) {
      Columns<3> J = Columns<3>::Zero();
      J.block<3, 3>(kV, 0) = -R_iT_;
      J.block<3, 3>(kP, 0) = -T * R_iT_;
      Write(Whiten(J), jacobians[1]);
    }
    if (jacobians[2] != nullptr) {
      Columns<6> J = Columns<6>::Zero();
      J.topRows<9>() = -delta_.bias_jacobian;
      J.topRows<3>() = -J_theta * so3::Exp(-theta_).toRotationMatrix() *
                       so3::RightJacobian(shift_theta_) * delta_.bias_jacobian.topRows<3>();
      J.bottomRows<6>() = -Eigen::Matrix<double, 6, 6>::Identity();
      Write(Whiten(J), jacobians[2]);
    }
    if (jacobians[3] != nullptr) {
      Columns<6> J = Columns<6>::Zero();
      J.block<3, 3>(kP, 0) = R_iT_;
      J.block<3, 3>(kTheta, 3) = J_theta;
      PoseManifold::Lift<15>(blocks_[3], Whiten(J), jacobians[3]);
    }
    if (jacobians[4] != nullptr) {
      Columns<3> J;
      J.noalias() = measurement_.W.middleCols<3>(kV) * R_iT_;
      Write(J, jacobians[4]);
    }
    if (jacobians[5] != nullptr) {
      const Columns<6> J = measurement_.W.rightCols<6>();
      Write(J, jacobians[5]);
    }
  }

  // Eq. 8: derivative in the direction of gravity, n_W.
  void WriteGravityJacobian(double gravity, const double* n_W, double* jacobian) const {
    const double T = delta_.duration;
    const Columns<3> whitened = -gravity * T * measurement_.W.middleCols<3>(kV) -
                                0.5 * gravity * T * T * measurement_.W.middleCols<3>(kP);
    const Eigen::Matrix<double, 3, 2> basis = R_iT_ * UnitDirectionManifold::Basis(n_W);
    UnitDirectionManifold::Lift<15>(n_W, whitened * basis, jacobian);
  }

 private:
  template <int kCols>
  Columns<kCols> Whiten(const Columns<kCols>& J) const {
    return measurement_.W.lazyProduct(J);
  }
  template <int kCols>
  static void Write(const Columns<kCols>& J, double* jacobian) {
    Eigen::Map<Eigen::Matrix<double, 15, kCols, Eigen::RowMajor>> out(jacobian);
    out = J;
  }

  const ImuMeasurement& measurement_;
  const ImuDelta& delta_;
  double const* const* blocks_;
  Eigen::Matrix3d R_iT_;
  Eigen::Quaterniond q_ij_;
  Eigen::Vector3d v_ij_, p_ij_, shift_theta_, theta_;
  Eigen::Matrix<double, 15, 1> e_;
};

}  // namespace

ImuMeasurement::ImuMeasurement(const ImuPreintegration& imu, double weight)
    : delta(imu.delta()), W(SqrtInformation(imu.covariance())) {
  RequirePositiveFinite(weight, "ImuFactor: the weight");
  W *= std::sqrt(weight);
}

ImuFactor::ImuFactor(const ImuPreintegration& imu, const Eigen::Vector3d& gravity_W, double weight)
    : measurement_(imu, weight), gravity_W_(gravity_W) {
  HIGHWALL_REQUIRE(gravity_W.allFinite(), "ImuFactor: gravity_W must be finite");
}

bool ImuFactor::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  const Linearization at(measurement_, parameters, gravity_W_);
  if (!at.IsFinite()) return false;
  at.WriteResidual(residuals);
  if (jacobians != nullptr) at.WriteJacobians(jacobians);
  return true;
}

ImuGravityFactor::ImuGravityFactor(const ImuPreintegration& imu, double gravity, double weight)
    : measurement_(imu, weight), gravity_(gravity) {
  RequirePositiveFinite(gravity, "ImuGravityFactor: gravity");
}

bool ImuGravityFactor::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const double* n_W = parameters[kGravity];
  const Linearization at(measurement_, parameters, gravity_ * ConstVector3(n_W));
  if (!at.IsFinite()) return false;
  at.WriteResidual(residuals);
  if (jacobians == nullptr) return true;
  at.WriteJacobians(jacobians);
  if (jacobians[kGravity] != nullptr) {
    at.WriteGravityJacobian(gravity_, n_W, jacobians[kGravity]);
  }
  return true;
}

}  // namespace highwall
