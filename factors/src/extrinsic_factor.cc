#include <highwall/factors/extrinsic_factor.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include <Eigen/Geometry>

#include <highwall/core/error.h>
#include <highwall/core/manifolds.h>
#include <highwall/core/so3.h>

#include "wrapped_factor.h"

namespace highwall {
namespace {

using internal::kMostBlocks;
using internal::kPoseBlock;
using internal::kPoseSize;

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, kPoseSize, Eigen::RowMajor>;

// Applies the chain rule so that out PlusJacobian(at) = of_camera PlusJacobian(T_WC) step. out: as
// many rows as of_camera, and may be of_camera itself.
void Chain(const Eigen::Ref<const Rows>& of_camera, const double* T_WC, const Matrix6& step,
           const double* at, double* out) {
  Eigen::Matrix<double, kPoseSize, 6, Eigen::RowMajor> plus;
  PoseManifold().PlusJacobian(T_WC, plus.data());
  const Eigen::Matrix<double, kPoseSize, 6> of_step = plus * step;
  for (Eigen::Index row = 0; row < of_camera.rows(); ++row) {
    const Eigen::Matrix<double, 1, 6> tangent = of_camera.row(row) * of_step;
    PoseManifold::Lift<1>(at, tangent, out + row * kPoseSize);
  }
}

}  // namespace

ExtrinsicFactor::ExtrinsicFactor(std::shared_ptr<const ceres::CostFunction> seen)
    : seen_(std::move(seen)) {
  HIGHWALL_REQUIRE(seen_ != nullptr && !seen_->parameter_block_sizes().empty() &&
                       seen_->parameter_block_sizes().front() == kPoseSize &&
                       seen_->parameter_block_sizes().size() < kMostBlocks,
                   "ExtrinsicFactor: the first block of the factor must be a pose");
  set_num_residuals(seen_->num_residuals());
  *mutable_parameter_block_sizes() = seen_->parameter_block_sizes();
  mutable_parameter_block_sizes()->push_back(kPoseSize);
}

bool ExtrinsicFactor::Evaluate(double const* const* parameters, double* residuals,
                               double** jacobians) const {
  const std::size_t last = seen_->parameter_block_sizes().size();
  const Eigen::Map<const Eigen::Vector3d> p_WB(parameters[kPoseBlock]), p_BC(parameters[last]);
  const Eigen::Map<const Eigen::Quaterniond> q_WB(parameters[kPoseBlock] + 3);
  const Eigen::Map<const Eigen::Quaterniond> q_BC(parameters[last] + 3);
  const Eigen::Matrix3d R_WB = q_WB.toRotationMatrix();
  std::array<double, kPoseSize> T_WC;
  Eigen::Map<Eigen::Vector3d>(T_WC.data()) = p_WB + R_WB * p_BC;
  Eigen::Map<Eigen::Quaterniond>(T_WC.data() + 3) = q_WB * q_BC;
  std::array<const double*, kMostBlocks> blocks;
  std::copy_n(parameters, last, blocks.begin());
  blocks[kPoseBlock] = T_WC.data();
  if (jacobians == nullptr) return seen_->Evaluate(blocks.data(), residuals, nullptr);

  std::array<double*, kMostBlocks> out;
  std::copy_n(jacobians, last, out.begin());
  Rows own;
  if (out[kPoseBlock] == nullptr && jacobians[last] != nullptr) {
    own.resize(num_residuals(), kPoseSize);
    out[kPoseBlock] = own.data();
  }
  if (!seen_->Evaluate(blocks.data(), residuals, out.data())) return false;
  if (out[kPoseBlock] == nullptr) return true;
  const Eigen::Map<const Rows> of_camera(out[kPoseBlock], num_residuals(), kPoseSize);
  if (jacobians[last] != nullptr) {
    Matrix6 step = Matrix6::Identity();  // Eq. 3
    step.topLeftCorner<3, 3>() = R_WB;
    Chain(of_camera, T_WC.data(), step, parameters[last], jacobians[last]);
  }
  if (jacobians[kPoseBlock] != nullptr) {
    Matrix6 step = Matrix6::Identity();  // Eq. 2
    step.topRightCorner<3, 3>() = -R_WB * so3::Hat(p_BC);
    step.bottomRightCorner<3, 3>() = q_BC.toRotationMatrix().transpose();
    Chain(of_camera, T_WC.data(), step, parameters[kPoseBlock], jacobians[kPoseBlock]);
  }
  return true;
}

}  // namespace highwall
