#include <highwall/factors/time_offset_factor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

#include "wrapped_factor.h"

namespace highwall {
namespace {

using internal::kMostBlocks;
using internal::kPoseBlock;
using internal::kPoseSize;

using RowsMap = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, kPoseSize, Eigen::RowMajor>>;

// Returns d(q_moved)/dq of q_moved = q step, in the order [x y z w].
Eigen::Matrix4d RightProduct(const Eigen::Quaterniond& step) {
  const double x = step.x(), y = step.y(), z = step.z(), w = step.w();
  Eigen::Matrix4d m;
  m << w, z, -y, x,   //
      -z, w, x, y,    //
      y, -x, w, z,    //
      -x, -y, -z, w;  //
  return m;
}

}  // namespace

TimeOffsetFactor::TimeOffsetFactor(std::shared_ptr<const ceres::CostFunction> seen,
                                   const Eigen::Vector3d& v_WB, const Eigen::Vector3d& omega_B,
                                   double t_d_state)
    : seen_(std::move(seen)), v_WB_(v_WB), omega_B_(omega_B), t_d_state_(t_d_state) {
  HIGHWALL_REQUIRE(seen_ != nullptr && !seen_->parameter_block_sizes().empty() &&
                       seen_->parameter_block_sizes().front() == kPoseSize &&
                       seen_->parameter_block_sizes().size() < kMostBlocks,
                   "TimeOffsetFactor: the first block of the factor must be a pose");
  HIGHWALL_REQUIRE(v_WB.allFinite() && omega_B.allFinite(),
                   "TimeOffsetFactor: v_WB and omega_B must be finite");
  HIGHWALL_REQUIRE(std::isfinite(t_d_state), "TimeOffsetFactor: t_d_state must be finite");
  set_num_residuals(seen_->num_residuals());
  *mutable_parameter_block_sizes() = seen_->parameter_block_sizes();
  mutable_parameter_block_sizes()->push_back(1);
}

bool TimeOffsetFactor::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const std::size_t count = seen_->parameter_block_sizes().size();
  const double dt = *parameters[count] - t_d_state_;
  const Eigen::Map<const Eigen::Vector3d> p(parameters[kPoseBlock]);
  const Eigen::Map<const Eigen::Quaterniond> q(parameters[kPoseBlock] + 3);
  const Eigen::Quaterniond step = so3::Exp(omega_B_ * dt);
  std::array<double, kPoseSize> moved;
  Eigen::Map<Eigen::Vector3d>(moved.data()) = p + v_WB_ * dt;
  const Eigen::Quaterniond q_moved = q * step;
  Eigen::Map<Eigen::Quaterniond>(moved.data() + 3) = q_moved;

  std::array<const double*, kMostBlocks> blocks;
  std::copy_n(parameters, count, blocks.begin());
  blocks[kPoseBlock] = moved.data();
  if (jacobians == nullptr) return seen_->Evaluate(blocks.data(), residuals, nullptr);

  // Jacobians of the wrapped factor with respect to the moved pose; t_d needs them, too.
  std::array<double*, kMostBlocks> out;
  std::copy_n(jacobians, count, out.begin());
  Eigen::Matrix<double, Eigen::Dynamic, kPoseSize, Eigen::RowMajor> own;
  if (out[kPoseBlock] == nullptr && jacobians[count] != nullptr) {
    own.resize(num_residuals(), kPoseSize);
    out[kPoseBlock] = own.data();
  }
  if (!seen_->Evaluate(blocks.data(), residuals, out.data())) return false;
  if (out[kPoseBlock] == nullptr) return true;
  RowsMap J(out[kPoseBlock], num_residuals(), kPoseSize);
  if (jacobians[count] != nullptr) {
    // d(q Exp(omega dt))/d(dt) = q Exp(omega dt) (omega / 2)                               Eq. 3
    const Eigen::Vector3d half = 0.5 * omega_B_;
    const Eigen::Quaterniond rate = q_moved * Eigen::Quaterniond(0.0, half.x(), half.y(), half.z());
    for (Eigen::Index row = 0; row < J.rows(); ++row) {
      jacobians[count][row] =
          J.row(row).head<3>().dot(v_WB_) + J.row(row).tail<4>().dot(rate.coeffs());
    }
  }
  if (jacobians[kPoseBlock] != nullptr) {
    const Eigen::Matrix4d dq_moved = RightProduct(step);
    for (Eigen::Index row = 0; row < J.rows(); ++row) {
      const Eigen::RowVector4d before = J.row(row).tail<4>();
      J.row(row).tail<4>().noalias() = before * dq_moved;  // Eq. 2
    }
  }
  return true;
}

}  // namespace highwall
