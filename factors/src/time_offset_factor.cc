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
using internal::kPoseSize;

using PoseBlock = std::array<double, kPoseSize>;
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

// Eq. 1
void Move(const double* before, const MovingPose& pose, double dt, PoseBlock* moved) {
  const Eigen::Map<const Eigen::Vector3d> p(before);
  const Eigen::Map<const Eigen::Quaterniond> q(before + 3);
  Eigen::Map<Eigen::Vector3d>(moved->data()) = p + pose.v_WB * dt;
  Eigen::Map<Eigen::Quaterniond>(moved->data() + 3) = q * so3::Exp(pose.omega_B * dt);
}

// Returns the derivative of the moved pose in t_d: d(q Exp(omega dt))/d(dt) is q' (omega / 2).
Eigen::Matrix<double, kPoseSize, 1> Rate(const PoseBlock& moved, const MovingPose& pose) {
  const Eigen::Map<const Eigen::Quaterniond> q(moved.data() + 3);
  const Eigen::Vector3d half = 0.5 * pose.omega_B;
  Eigen::Matrix<double, kPoseSize, 1> rate;
  rate << pose.v_WB, (q * Eigen::Quaterniond(0.0, half.x(), half.y(), half.z())).coeffs();
  return rate;
}

}  // namespace

TimeOffsetFactor::TimeOffsetFactor(std::shared_ptr<const ceres::CostFunction> seen,
                                   const Eigen::Vector3d& v_WB, const Eigen::Vector3d& omega_B,
                                   double t_d_state)
    : TimeOffsetFactor(std::move(seen), std::vector<MovingPose>{{0, v_WB, omega_B, t_d_state}}) {}

TimeOffsetFactor::TimeOffsetFactor(std::shared_ptr<const ceres::CostFunction> seen,
                                   std::vector<MovingPose> poses)
    : seen_(std::move(seen)), poses_(std::move(poses)) {
  HIGHWALL_REQUIRE(seen_ != nullptr && seen_->parameter_block_sizes().size() < kMostBlocks,
                   "TimeOffsetFactor: there must be a factor, with few blocks");
  const std::vector<int>& sizes = seen_->parameter_block_sizes();
  HIGHWALL_REQUIRE(!poses_.empty(), "TimeOffsetFactor: a pose must move");
  for (const MovingPose& pose : poses_) {
    HIGHWALL_REQUIRE(pose.block < sizes.size() && sizes[pose.block] == kPoseSize,
                     "TimeOffsetFactor: what moves must be a pose, by default the first block");
    HIGHWALL_REQUIRE(std::ranges::count(poses_, pose.block, &MovingPose::block) == 1,
                     "TimeOffsetFactor: a pose must be given once");
    HIGHWALL_REQUIRE(pose.v_WB.allFinite() && pose.omega_B.allFinite(),
                     "TimeOffsetFactor: v_WB and omega_B must be finite");
    HIGHWALL_REQUIRE(std::isfinite(pose.t_d_state), "TimeOffsetFactor: t_d_state must be finite");
  }
  set_num_residuals(seen_->num_residuals());
  *mutable_parameter_block_sizes() = sizes;
  mutable_parameter_block_sizes()->push_back(1);
}

bool TimeOffsetFactor::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const std::size_t count = seen_->parameter_block_sizes().size();
  std::array<const double*, kMostBlocks> blocks;
  std::copy_n(parameters, count, blocks.begin());
  std::array<PoseBlock, kMostBlocks> moved;
  for (const MovingPose& pose : poses_) {
    Move(parameters[pose.block], pose, *parameters[count] - pose.t_d_state, &moved[pose.block]);
    blocks[pose.block] = moved[pose.block].data();
  }
  if (jacobians == nullptr) return seen_->Evaluate(blocks.data(), residuals, nullptr);

  // Jacobians of the wrapped factor with respect to the moved poses; t_d needs them, too.
  std::array<double*, kMostBlocks> out;
  std::copy_n(jacobians, count, out.begin());
  double* const by_offset = jacobians[count];
  std::array<Eigen::Matrix<double, Eigen::Dynamic, kPoseSize, Eigen::RowMajor>, kMostBlocks> own;
  for (const MovingPose& pose : poses_) {
    if (out[pose.block] != nullptr || by_offset == nullptr) continue;
    own[pose.block].resize(num_residuals(), kPoseSize);
    out[pose.block] = own[pose.block].data();
  }
  if (!seen_->Evaluate(blocks.data(), residuals, out.data())) return false;
  if (by_offset != nullptr) std::fill_n(by_offset, num_residuals(), 0.0);
  for (const MovingPose& pose : poses_) {
    if (out[pose.block] == nullptr) continue;
    RowsMap J(out[pose.block], num_residuals(), kPoseSize);
    if (by_offset != nullptr) {
      Eigen::Map<Eigen::VectorXd>(by_offset, num_residuals()) +=
          J * Rate(moved[pose.block], pose);  // Eq. 3
    }
    if (jacobians[pose.block] == nullptr) continue;
    const Eigen::Matrix4d dq_moved =
        RightProduct(so3::Exp(pose.omega_B * (*parameters[count] - pose.t_d_state)));
    for (Eigen::Index row = 0; row < J.rows(); ++row) {
      const Eigen::RowVector4d before = J.row(row).tail<4>();
      J.row(row).tail<4>().noalias() = before * dq_moved;  // Eq. 2
    }
  }
  return true;
}

}  // namespace highwall
